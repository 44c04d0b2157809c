"""Every engine that is always there keeps the contract; optional ones have tests of their own."""

import pytest
from spincheck.engines.contract import contract_tests

pytestmark = pytest.mark.slow

test_contract = contract_tests("mujoco", "mujoco-urdf", "pybullet")
