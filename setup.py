"""Finds the packages: every folder of Python files below the four of `package-dir`."""

from setuptools import find_packages, setup

TOPS = ("engines", "reference", "reports", "scenarios")
INCLUDED = (*TOPS, *(f"{top}.*" for top in TOPS))

setup(packages=[f"spincheck.{name}" for name in find_packages(include=INCLUDED)])
