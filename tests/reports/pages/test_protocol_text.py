"""The texts that quote constants of the code find them: quick, as any change may rename one."""

import pytest
from spincheck.reports.pages.render import RULES
from spincheck.reports.pages.templating import templates


@pytest.mark.parametrize("text", ["protocol.md", "hard.md"])
def test_every_constant_that_a_text_quotes_is_there(text: str) -> None:
    assert templates().get_template(text).render(count=1, **RULES)
