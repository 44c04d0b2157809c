"""Names of pages and of anchors in them."""

from urllib.parse import quote


def scene_page(name: str) -> str:
    """A scene's page, relative to the report's folder."""
    return f"scenes/{quote(name)}.html"


def sweep_page(kind: str, name: str) -> str:
    """The page of a map or an ensemble, likewise."""
    return f"{kind}s/{quote(name)}.html"


def method_anchor(engine: str, method: str) -> str:
    """The anchor of a method's verdict on a scene's page."""
    return ":".join(("method", _plain(engine), _plain(method)))


def _plain(text: str) -> str:
    """ASCII letters, digits, - and _ unchanged; other characters as their code points."""
    return "".join(
        c if c.isascii() and (c.isalnum() or c in "-_") else f".{ord(c):x}." for c in text
    )
