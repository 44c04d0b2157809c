"""What docstrings describe exists; they begin with what is returned or done; names are nouns."""

import ast
import re
from collections.abc import Callable, Iterator

import pytest
from sources import trees

SECTION = re.compile(r"^(?:Parameters|Attributes)\n-+\n(.*?)(?:\n\n|\Z)", re.DOTALL | re.MULTILINE)
#: At the margin of a section: names, a colon, and what they are.
ENTRY = re.compile(r"^([\w, *]+?) : ", re.MULTILINE)


def described(docstring: str) -> Iterator[str]:
    for section in SECTION.findall(docstring):
        for names in ENTRY.findall(section):
            yield from (name.strip("* ") for name in names.split(","))


def names_of(node: ast.FunctionDef | ast.ClassDef) -> set[str]:
    """Parameters of a function; of a class whatever it defines or its methods take and set."""
    inside = list(ast.walk(node)) if isinstance(node, ast.ClassDef) else list(ast.walk(node.args))
    names = {part.arg for part in inside if isinstance(part, ast.arg)}
    names |= {part.id for part in inside if isinstance(part, ast.Name)}
    names |= {part.attr for part in inside if isinstance(part, ast.Attribute)}
    return names | {part.name for part in inside if isinstance(part, ast.FunctionDef)}


def unknown(tree: ast.Module) -> list[str]:
    """Names that docstrings describe and that their function or class does not have."""
    return [
        f"{node.name}: {name}"
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef | ast.ClassDef)
        for name in described(ast.get_docstring(node) or "")
        if name not in names_of(node) and not inherits(node)
    ]


def inherits(node: ast.AST) -> bool:
    """Whether a class may have what it describes from a base; protocols and tuples have not."""
    return isinstance(node, ast.ClassDef) and any(
        ast.unparse(base) not in ("NamedTuple", "Protocol", "ABC") for base in node.bases
    )


def test_a_stale_name_is_noticed() -> None:
    source = (
        'def f(a):\n    """Do.\n\n    Parameters\n    ----------\n    a, b : numbers\n    """\n'
    )
    assert unknown(ast.parse(source)) == ["f: b"]


#: A sentence that begins so has no subject.
PREPOSITIONS = {"At", "Between", "By", "For", "From", "In", "Of", "On", "So", "To", "With"}
#: Participles that say what was done, and not what a thing is.
PARTICIPLES = {"asked", "felt", "heard", "held", "told"}


def subjectless(tree: ast.Module) -> list[str]:
    """Functions and classes whose docstring begins with a preposition."""
    return [
        node.name
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef | ast.ClassDef)
        and (ast.get_docstring(node) or "The").split()[0].strip(",;:") in PREPOSITIONS
    ]


def participles(tree: ast.Module) -> list[str]:
    """Names of classes, functions, parameters, variables and attributes that are one."""
    nodes = list(ast.walk(tree))
    names = [node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.ClassDef)]
    names += [node.arg for node in nodes if isinstance(node, ast.arg)]
    names += [n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
    names += [
        n.attr for n in nodes if isinstance(n, ast.Attribute) and isinstance(n.ctx, ast.Store)
    ]
    return [name for name in names if name.strip("_").lower() in PARTICIPLES]


@pytest.mark.parametrize("faults", [unknown, subjectless, participles])
def test_docstrings_and_names_are_in_order(faults: Callable[[ast.Module], list[str]]) -> None:
    by_file = {name: faults(tree) for name, tree in trees().items()}
    assert {name: found for name, found in by_file.items() if found} == {}


def test_a_riddle_is_noticed() -> None:
    tree = ast.parse(
        'class _Told:\n    """Of rows."""\n\n    def f(self, held):\n        self.asked = held\n'
    )
    assert subjectless(tree) == ["_Told"]
    assert sorted(participles(tree)) == ["_Told", "asked", "held"]
