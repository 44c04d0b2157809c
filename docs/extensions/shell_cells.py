"""Shows notebook cells of other languages without the line that tells IPython so.

``%%bash`` becomes a block of shell commands, ``%%writefile NAME`` one with the name above it.
"""

from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx

SHELL, FILE = "%%bash", "%%writefile "
LANGUAGES = {".c": "c", ".py": "python", ".toml": "toml", ".urdf": "xml"}


def without_magic(_: Sphinx, document: nodes.document) -> None:
    """Rewrite the code blocks of a page that begin so."""
    for block in list(document.findall(nodes.literal_block)):
        magic, _, text = block.astext().partition("\n")
        if magic.startswith(SHELL):
            block.replace_self(nodes.literal_block(text, text, language="sh"))
        elif magic.startswith(FILE):
            name = magic.removeprefix(FILE).strip()
            language = LANGUAGES[Path(name).suffix]
            shown = nodes.literal_block(text, text, language=language)
            block.replace_self([nodes.paragraph("", "", nodes.literal(name, name)), shown])


def setup(app: Sphinx) -> dict[str, bool]:
    """Have it done after a page was read."""
    app.connect("doctree-read", without_magic)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
