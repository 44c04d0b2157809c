"""What a failure of a test means, and the public issues that the test would have caught."""

from collections.abc import Callable
from typing import TypeVar

Test = TypeVar("Test", bound=Callable[..., None])


def failure_means(sentence: str, *issues: str) -> Callable[[Test], Test]:
    """Return a decorator that attaches to a test a sentence, shown if the test fails.

    Parameters
    ----------
    sentence : what a failure of the test means
    issues : issues or pull requests on GitHub about faults that the test would have caught, as
        ``owner/repository#number``
    """
    urls = tuple(f"https://github.com/{issue.replace('#', '/issues/')}" for issue in issues)

    def attach(test: Test) -> Test:
        vars(test).update(sentence=sentence, issues=urls)
        return test

    return attach
