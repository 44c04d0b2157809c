"""The page of every engine and method is of what was measured and of the newest results.

Verified: it is what `make methods` would write of the files that are there. Not verified: the
measurements, which take engines that are not installed everywhere.
"""

import json

from measure_methods import KEPT, PAGE, page


def test_the_page_of_methods_is_of_the_newest_results() -> None:
    kept = json.loads(KEPT.read_text(encoding="utf-8"))
    assert PAGE.read_text(encoding="utf-8") == page(kept)
