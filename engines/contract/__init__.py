"""The requirements on every engine, as tests to run on this package's engines and on others.

How to use them on an engine of one's own: docs/how-to/add-an-engine.md.
"""

from .checks import CHECKS, Check, ContractBroken
from .tests import contract_tests

__all__ = ["CHECKS", "Check", "ContractBroken", "contract_tests"]
