"""A base for made-up sessions: nothing goes wrong, nothing acts, and there is nothing to free."""

from spincheck.engines import Session


class QuietSession(Session):
    """Body, state and steps are left to the subclass."""

    def check(self) -> None:
        pass

    def active(self) -> frozenset[str]:
        return frozenset()

    def close(self) -> None:
        pass
