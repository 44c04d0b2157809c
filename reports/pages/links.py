"""Names of pages and of anchors in them."""

from urllib.parse import quote


def scene_page(name: str) -> str:
    """A scene's page, relative to the report's folder."""
    return f"scenes/{quote(name)}.html"


def map_page(name: str) -> str:
    """A map's page, likewise."""
    return f"maps/{quote(name)}.html"


def ensemble_page(name: str) -> str:
    """An ensemble's page, likewise."""
    return f"ensembles/{quote(name)}.html"


def method_anchor(engine: str, method: str) -> str:
    """The anchor of a method's verdict on a scene's page."""
    return ":".join(("method", _plain(engine), _plain(method)))


def _plain(text: str) -> str:
    """ASCII letters, digits, - and _ unchanged; other characters as their code points."""
    return "".join(
        c if c.isascii() and (c.isalnum() or c in "-_") else f".{ord(c):x}." for c in text
    )
