"""No module imports one that imports it, at whatever depth: also within functions and for types."""

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = ("scenarios", "reference", "engines", "reports")
INTERFACE = ("reports", "interface")
HARNESS = ("reports", "harness")
MOST_ROOMS, MOST_FLOORS = 16, 5


def sources_below(root: Path) -> dict[tuple[str, ...], str]:
    """Sources by their dotted names, of packages those of their `__init__`."""
    return {
        dotted(path, root): path.read_text(encoding="utf-8")
        for package in PACKAGES
        for path in (root / package).rglob("*.py")
    }


def dotted(path: Path, root: Path) -> tuple[str, ...]:
    """The name of a module without `spincheck`, which is what a folder of its own holds."""
    name = (*path.relative_to(root).parent.parts, *([path.stem] * (path.stem != "__init__")))
    return name[len(INTERFACE) :] if name[: len(INTERFACE)] == INTERFACE else name


def imported(
    module: tuple[str, ...], sources: dict[tuple[str, ...], str], is_package: bool
) -> Iterator[tuple[str, ...]]:
    """The modules of the project that a module names in any import statement."""
    for node in ast.walk(ast.parse(sources[module])):
        if not isinstance(node, ast.ImportFrom):
            continue
        within = module[: len(module) - node.level + is_package] if node.level else ()
        base = (*within, *(node.module or "").split("."))
        base = tuple(part for part in base if part and part != "spincheck")
        for name in node.names:
            target = (*base, name.name) if (*base, name.name) in sources else base
            if target in sources and target != module:
                yield target


def circle(root: Path) -> list[str]:
    """The modules of a circle, or none."""
    sources = sources_below(root)
    packages = {
        dotted(path, root) for package in PACKAGES for path in (root / package).rglob("__init__.py")
    }
    graph = {module: set(imported(module, sources, module in packages)) for module in sources}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return ["/".join(module) for module in error.args[1]]
    return []


def test_no_imports_go_in_a_circle() -> None:
    assert circle(ROOT) == []


def test_circles_that_are_planted_are_found(tmp_path: Path) -> None:
    folder = tmp_path / "scenarios" / "effects"
    folder.mkdir(parents=True)
    (tmp_path / "scenarios/scene.py").write_text("from .effects import drag\n")
    (folder / "__init__.py").write_text("")
    (folder / "drag.py").write_text("import math\n")
    assert circle(tmp_path) == []
    for text in (
        "if TYPE_CHECKING:\n    from ..scene import Scene\n",
        "def load():\n    from spincheck.scenarios.scene import load\n",
        "from .. import scene\n",
    ):
        (folder / "drag.py").write_text(text)
        assert set(circle(tmp_path)) == {"scenarios/scene", "scenarios/effects/drag"}


def test_the_harness_has_few_rooms_on_few_floors() -> None:
    """Its folders, and files beside them, are rooms; a floor's import from those below alone."""
    sources = sources_below(ROOT)
    rooms: dict[str, set[str]] = {}
    for module in sources:
        if module[:2] == HARNESS and len(module) > 2:
            others = (one for one in imported(module, sources, False) if one[:2] == HARNESS)
            below = {one[2] for one in others if len(one) > 2}
            rooms.setdefault(module[2], set()).update(below - {module[2]})
    graph, floors = TopologicalSorter(rooms), 0
    graph.prepare()
    while floor := graph.get_ready():
        graph.done(*floor)
        floors += 1
    assert len(rooms) <= MOST_ROOMS
    assert floors <= MOST_FLOORS
