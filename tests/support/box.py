"""The scene that planted engines are run on: a free body, cheap to step in Python."""

BOX = """
spincheck = 1
title = "A tumbling box"
source = "made up"
[body]
mass = 2.0
inertia = [1.0, 2.0, 2.5]
[start]
euler_zyz_deg = [10.0, 40.0, 70.0]
omega_body = [1.0, 2.0, 0.5]
[window]
duration = 1.0
samples = 11
"""
