"""What every engine promises, as tests: ours pass them, and a stranger's shows that it does.

How to use them on an engine of one's own: docs/add-an-engine.md.
"""

from .checks import CHECKS, Check, ContractBroken
from .tests import contract_tests

__all__ = ["CHECKS", "Check", "ContractBroken", "contract_tests"]
