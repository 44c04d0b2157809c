"""Digests of Python sources without what changes no result, and what the sources import.

Parsing the whole program takes a second. So digests and imports are kept in the user's cache, by
the digest of a file's content.
"""

import ast
import atexit
import json
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

from ...engines.user_cache import user_cache
from ...scenarios.regular_files import read_regular, write_new

#: Largest size of the cache, bytes: enough for some twenty versions of the program.
LARGEST = 1 << 22


class Import(NamedTuple):
    """One statement `from MODULE import NAMES`, or one module of a statement `import MODULE`.

    Attributes
    ----------
    level : number of dots before the module's name; 0 if the import is absolute
    module : the module's name without the dots; may be empty
    names : for each imported name, the name itself and the name that it is given (`as`); none for
        `import MODULE`
    outside : whether the statement is at the top level of the importing file, outside of any
        function, class or other block
    """

    level: int
    module: str
    names: tuple[tuple[str, str], ...]
    outside: bool


class Source(NamedTuple):
    """The digest of a Python file, and its imports.

    Attributes
    ----------
    digest : digest of the file without docstrings, comments and layout, which change no result
    imports : what the file imports, in any order
    """

    digest: str
    imports: tuple[Import, ...]


@cache
def source(path: Path) -> Source:
    """Return the digest and the imports of a Python file.

    A file that this version of Python cannot parse has the digest of its bytes, and no imports.
    """
    content = path.read_bytes()
    known, key = _known(), sha256(content).hexdigest()
    if key not in known:
        try:
            tree = ast.parse(content)
        except (SyntaxError, ValueError):
            return Source(key, ())
        digest = sha256(repr(_meaning(tree)).encode()).hexdigest()
        known[key] = Source(digest, tuple(_imports(tree)))
    return known[key]


@cache
def _known() -> dict[str, Source]:
    """Return the cached sources, by the digest of the file's content; they are saved at exit."""
    known = {}
    with suppress(OSError, ValueError, TypeError, AttributeError):
        kept = json.loads(read_regular(_file(), LARGEST))
        known = {key: _restored(*parts) for key, parts in kept.items()}
    atexit.register(_keep, known, len(known))
    return known


def _restored(digest: str, imports: list[list[Any]]) -> Source:
    found = [
        Import(level, of, tuple((a, b) for a, b in names), out) for level, of, names, out in imports
    ]
    return Source(digest, tuple(found))


def _keep(known: dict[str, Source], before: int) -> None:
    text = json.dumps(known)
    with suppress(OSError):
        if before < len(known) and len(text) < LARGEST:
            _file().parent.mkdir(parents=True, exist_ok=True)
            write_new(_file(), text)


def _file() -> Path:
    """Return the path of the cache; every version of this module has a cache of its own."""
    own = sha256(Path(__file__).read_bytes()).hexdigest()[:16]
    return user_cache() / f"sources-{own}.json"


def _imports(tree: ast.Module) -> Iterator[Import]:
    outside = {id(node) for node in tree.body}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            names = tuple((alias.name, alias.asname or alias.name) for alias in node.names)
            yield Import(node.level, node.module or "", names, id(node) in outside)
        elif isinstance(node, ast.Import):
            for alias in node.names:
                yield Import(0, alias.name, (), id(node) in outside)


def _meaning(node: object) -> object:
    """Return a syntax tree without what changes no result: docstrings, comments, layout.

    Every string that is a statement is left out like a docstring. Empty fields are left out, as
    versions of Python differ in which of them a tree has.
    """
    if isinstance(node, list):
        return [_meaning(one) for one in node if not _is_text_alone(one)]
    if not isinstance(node, ast.AST):
        return node
    fields = [(name, _meaning(value)) for name, value in ast.iter_fields(node)]
    return type(node).__name__, [(n, value) for n, value in fields if value not in (None, [])]


def _is_text_alone(node: object) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )
