"""Finds the packages: every folder of Python files below the four of `package-dir`."""

from setuptools import find_packages, setup

TOPS = ("engines", "reference", "reports", "scenarios")
INCLUDED = (*TOPS, *(f"{top}.*" for top in TOPS))
#: The folder that is the package `spincheck` itself.
INTERFACE = "reports.interface"

found = find_packages(include=INCLUDED, exclude=(f"{INTERFACE}*",))
setup(packages=["spincheck", "spincheck.suite", *(f"spincheck.{name}" for name in found)])
