"""The engines of this installation keep the contract; optional ones have tests of their own."""

import pytest
from spincheck.engines import engines
from spincheck.engines.contract import contract_tests

pytestmark = pytest.mark.slow

# PyBullet has no wheels for every Python.
test_contract = contract_tests("mujoco", "mujoco-urdf", *({"pybullet"} & engines().keys()))
