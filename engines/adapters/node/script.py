"""JavaScript that makes a run of an engine under node and needs only the engine's npm package.

It consists of the modules that the engine's `.mjs` file imports, of that file up to the end of its
function `open`, without the protocol that follows, and of the scene record that `open` takes.
"""

import json
import re
from pathlib import Path

from spincheck.engine import Method, Scenario

from ...scene_record import ABOUT, scene_record

HERE = Path(__file__).parent
#: Pattern of an import from the folder `parts`: the names, and the file.
_IMPORT = re.compile(r"^import \{ (.+) \} from '\./(parts/[\w-]+\.mjs)';\n", re.MULTILINE)
#: Pattern of the whole function that builds the scene.
_OPEN = re.compile(r"^function open\(.*?^\}\n", re.MULTILINE | re.DOTALL)
_SCRIPT = """\
// Run it with node in the folder in which `npm install {package}` was run, or give it the path of
// that folder's node_modules.
{parts}
{engine}
const SCENE = {{
{scene}
}};
const held = open(SCENE, {method}, TIMESTEP);

function step(count) {{
  held.advance(count);
}}

// Attitude, w x y z, body to world, and angular velocity in body axes.
function state() {{
  const {{ q, omega }} = held.state();
  const attitude = product(q.map((x) => x / Math.hypot(...q)), conjugate(SCENE.axes));
  return [attitude, turned(conjugate(attitude), omega)];
}}
"""


def script(path: Path, scenario: Scenario, method: Method) -> str:
    """Return JavaScript that builds and steps a scene with a method of an engine.

    The code uses the name `TIMESTEP` for the timestep, s, and does not define it.

    Parameters
    ----------
    path : the engine's `.mjs` file
    """
    text = path.read_text(encoding="utf-8")
    found = _OPEN.search(text)
    assert found is not None, f"{path.name} has no function 'open'"
    kept = text[: found.end()]
    engine = _IMPORT.sub("", kept)
    parts = [
        _part(HERE / part)
        for names, part in _IMPORT.findall(kept)
        if any(re.search(rf"\b{name}\b", engine) for name in names.split(", "))
    ]
    return _SCRIPT.format(
        package=_package(text),
        parts="\n".join(parts),
        engine=engine,
        scene="\n".join(_entries(scenario)),
        method=json.dumps(method.name),
    )


def _part(path: Path) -> str:
    """Return the text of a JavaScript module without the word "export" before its definitions."""
    return re.sub(r"^export ", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE)


def _package(text: str) -> str:
    """Return the npm package that an engine loads, as name@version.

    The version is the one in `package.json`. `text` is the text of the engine's `.mjs` file.
    """
    wanted = json.loads((HERE / "package.json").read_text(encoding="utf-8"))["dependencies"]
    (package,) = (f"{name}@{version}" for name, version in wanted.items() if f"'{name}/" in text)
    return package


def _entries(scenario: Scenario) -> list[str]:
    """Return lines of JavaScript, the entries of an object that is the scene's record."""
    record = scene_record(scenario)
    return [f"  {key}: {json.dumps(record[key])},  // {ABOUT[key]}" for key in record]
