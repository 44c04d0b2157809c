"""The page with sliders computes the exact motion; the notebooks run as the site is built."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import spincheck

COURSE = Path(__file__).parents[1] / "docs" / "course"
#: rad, and relative of ω: what the page promises.
PROMISED = 1e-7
MASS, ARM, GRAVITY = 1.0, 0.06, 9.81


def start(moments, arm, tilt, omega):
    """A top as the page's script and as a scene take it."""
    q = [np.cos(tilt / 2), 0.0, np.sin(tilt / 2), 0.0]
    about_pivot = np.array(moments) + MASS * arm**2 * np.array([1, 1, 0])
    page = {"moments": about_pivot.tolist(), "mgl": MASS * GRAVITY * arm, "q": q, "omega": omega}
    tables = {
        "title": "From the sliders",
        "source": "the page",
        "body": {"mass": MASS, "inertia": moments, "com": [0.0, 0.0, arm]},
        "start": {"quaternion_wxyz": q, "omega_body": omega},
        "effects": {"gravity": {"acceleration": [0.0, 0.0, -GRAVITY]}, "pivot": {}} if arm else {},
        "window": {"duration": 3.0, "samples": 301},
    }
    return page, tables


TOPS = [
    start([2.5e-3, 2.5e-3, 5e-3], ARM, np.radians(30.0), [0.0, 0.0, 40.0]),
    start([2.5e-3, 2.5e-3, 5e-3], ARM, np.radians(1.0), [-0.1, 0.0, 30.0]),
    start([2.5e-3, 5e-3, 6e-3], 0.0, np.radians(89.0), [0.01, 20.0, 0.02]),
    start([2.5e-3, 3e-3, 4e-3], ARM, np.radians(120.0), [1.0, 0.5, 10.0]),
]


@pytest.mark.processes
@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
@pytest.mark.parametrize(
    ("top", "gyroscopic"), [*((top, True) for top in range(len(TOPS))), (3, False)]
)
def test_the_sliders_page_computes_the_exact_motion(top, gyroscopic):
    page, tables = TOPS[top]
    (computes,) = re.findall(
        r"<script>\n(// The motion.*?)</script>",
        (COURSE / "sliders.html").read_text("utf-8"),
        re.DOTALL,
    )
    if not gyroscopic:  # the planted fault
        assert "(B - C) * r * s + " in computes
        computes = computes.replace("(B - C) * r * s + ", "")
    times = np.linspace(0.0, 3.0, 301)
    call = f"console.log(JSON.stringify(motion({json.dumps(page)}, {json.dumps(times.tolist())})))"
    done = subprocess.run(
        ["node", "-e", computes + call], capture_output=True, text=True, check=True
    )
    states = np.array(json.loads(done.stdout))
    judged = spincheck.judge(tables, t=times, q_wxyz=states[:, :4], omega_body=states[:, 4:])
    close = judged.errors["attitude"] < PROMISED and judged.errors["omega"] < PROMISED
    assert close == gyroscopic, judged.errors
