"""A run of an engine under node as JavaScript that needs its npm package alone.

It is the text of the engine's own file up to the end of its function `open`, without the protocol
that follows, together with the modules that the file imports and the scene as `open` receives it.
"""

import json
import re
from pathlib import Path

from spincheck.engine import Method, Scenario

from ...scene_record import ABOUT, scene_record

HERE = Path(__file__).parent
#: Pattern of an import from the folder `parts`: the names, and the file.
_IMPORT = re.compile(r"^import \{ (.+) \} from '\./(parts/[\w-]+\.mjs)';\n", re.MULTILINE)
#: Pattern of the function that builds the scene, up to its last line.
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
    """Return JavaScript that builds and steps a scene with a method of the engine in `path`.

    The timestep is left to the name `TIMESTEP`, which the code does not define.
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
    """Return the text of a module without the word "export" before what it defines."""
    return re.sub(r"^export ", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE)


def _package(text: str) -> str:
    """Return the npm package that an engine's file loads, as name@version.

    The version is the one in `package.json`. `text` is the engine's file.
    """
    wanted = json.loads((HERE / "package.json").read_text(encoding="utf-8"))["dependencies"]
    (package,) = (f"{name}@{version}" for name, version in wanted.items() if f"'{name}/" in text)
    return package


def _entries(scenario: Scenario) -> list[str]:
    """Return the lines of a scene's record as entries of a JavaScript object."""
    record = scene_record(scenario)
    return [f"  {key}: {json.dumps(record[key])},  // {ABOUT[key]}" for key in record]
