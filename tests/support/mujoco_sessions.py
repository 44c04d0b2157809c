"""MuJoCo sessions for tests: from any MJCF text, so that a trap can be planted in it."""

import mujoco
from spincheck.engines.adapters.mujoco.session import MuJoCoSession
from spincheck.engines.checks.read_back import READ_BACK_SLACK, differences
from spincheck.engines.models.mjcf import mjcf
from spincheck.scenarios import Scenario

TIMESTEP = 1e-3


def loaded(scene: Scenario, text: str) -> MuJoCoSession:
    """A session on the model of an MJCF text, at its first keyframe."""
    model = mujoco.MjModel.from_xml_string(text)
    start = model.key(0)
    return MuJoCoSession(scene, model, start.qpos, start.qvel)


def session_of(scene: Scenario, integrator: str = "RK4") -> MuJoCoSession:
    """A session as the adapter opens it."""
    return loaded(scene, mjcf(scene, TIMESTEP, integrator))


def planted(scene: Scenario, *traps: tuple[str, str]) -> MuJoCoSession:
    """A session whose MJCF has been tampered with: what stood there, and what stands there now."""
    text = mjcf(scene, TIMESTEP, "RK4")
    for old, new in traps:
        assert old in text
        text = text.replace(old, new)
    return loaded(scene, text)


def read_back(scene: Scenario, session: MuJoCoSession) -> None:
    """What the run loop does before the first step."""
    held = session.read_body(), session.read_state()
    assert [one.complaint for one in differences(scene, *held, READ_BACK_SLACK)] == []
