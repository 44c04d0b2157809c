"""Every engine that is always there keeps the contract; optional ones have tests of their own."""

from spincheck.engines.contract import contract_tests

test_contract = contract_tests("mujoco", "mujoco-urdf", "pybullet")
