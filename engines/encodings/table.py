"""The encodings: other descriptions of a scene's body and motion that mean the same."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

from mpmath import mpf

from ...scenarios import Scenario
from ...scenarios.exact import normalised
from ...scenarios.principal import from_matrix, principal_axes
from ..engine import Engine
from ..models.description import PLAIN, TURN, Description, away_from
from ..models.shape import box_sides
from .changed_scene import FREE_FALL, OF_BODIES, OF_ONE_BODY, ON_A_TABLE, SceneChange

#: Number of changed scenes that are kept, as every method runs them at several timesteps.
KEPT = 64
#: Quaternion of the turn after which body axes x, y, z are named y, z, x.
CYCLE = (mpf("0.5"), mpf("0.5"), mpf("0.5"), mpf("0.5"))
#: Quaternion of a turn by 161°, after which the products of inertia are large.
FAR_TURN = normalised((1, 3, 1, 5))


def _none(scenario: Scenario) -> SceneChange:  # noqa: ARG001
    """Return the change that leaves axes, origin and units as they are."""
    return SceneChange()


@lru_cache(maxsize=KEPT)
def _scene(change: Callable[[Scenario], SceneChange], scenario: Scenario) -> Scenario:
    """Return a scene in the axes, origin and units of an encoding; recent results are cached.

    Parameters
    ----------
    change : function that returns how a scene is changed (`Encoding.change`)
    """
    return change(scenario).scene(scenario)


@dataclass(frozen=True)
class Encoding:
    """An encoding: another description of a scene's body and motion that means the same.

    Attributes
    ----------
    name : as users type it
    summary : what it changes, in words
    change : function that returns the change of axes, origin and units of a scene
    description : how the changed body is written into a model
    effects : names of the effects that a scene may have if it is to be given in this encoding
    needs_free : whether the encoding applies only to scenes with a free body
    """

    name: str
    summary: str
    change: Callable[[Scenario], SceneChange] = _none
    description: Description = PLAIN
    effects: frozenset[str] = OF_BODIES
    needs_free: bool = False

    def scene(self, scenario: Scenario) -> Scenario:
        """Return a scene in the axes, origin and units of this encoding."""
        return _scene(self.change, scenario)

    def why_not(self, engine: Engine, scenario: Scenario) -> str:
        """Return why an engine cannot be given a scene in this encoding; empty if it can."""
        if beyond := sorted(self.description.features - engine.describes):
            return f"{engine.name}'s models have no words for it: {', '.join(beyond)}"
        if beyond := sorted(scenario.called_for - self.effects):
            return f"it is not of scenes with {', '.join(beyond)}"
        if self.needs_free and not scenario.constraint.is_free:
            return "it is of free bodies"
        body = scenario.carrier
        moments = [float(m) for m in principal_axes(body.inertia_com_exact)[0]]
        if self.description.shape and not min(box_sides(body.mass, moments)):
            return "the body is flat: no box has its inertia"
        return ""


def _away(scenario: Scenario) -> SceneChange:
    """Return the change to an origin far from the body's, in proportion to the body's size."""
    return SceneChange(shift=away_from(scenario.body))


def _principal(scenario: Scenario) -> SceneChange:
    """Return the change to body axes that are principal, with the origin at the com."""
    _, R_body_axes = principal_axes(scenario.body.inertia_com_exact)
    return SceneChange(q_body_new=from_matrix(R_body_axes), shift=scenario.body.com_exact)


ENCODINGS: dict[str, Encoding] = {
    one.name: one
    for one in (
        Encoding(
            "turned",
            "body frame turned by 74°, about none of its axes",
            lambda _: SceneChange(q_body_new=TURN),
            effects=ON_A_TABLE,
        ),
        Encoding(
            "permuted",
            "body axes x, y, z named y, z, x",
            lambda _: SceneChange(q_body_new=CYCLE),
            effects=ON_A_TABLE,
        ),
        Encoding(
            "full-tensor",
            "body frame turned by 161°, and the tensor written whole, with its products of inertia",
            lambda _: SceneChange(q_body_new=FAR_TURN),
            Description(full_tensor=True),
            ON_A_TABLE,
        ),
        Encoding(
            "shape",
            "inertia of a box of a density, not stated",
            description=Description(shape=True),
        ),
        Encoding(
            "welded",
            "inertia on a body welded to a root without mass",
            description=Description(parts="welded"),
        ),
        Encoding(
            "nested",
            "two roots without mass, one off and turned, the inertia welded back",
            description=Description(parts="nested"),
        ),
        Encoding(
            "halves", "the mass on two bodies, welded", description=Description(parts="halves")
        ),
        Encoding(
            "thirds", "the mass on three bodies, welded", description=Description(parts="thirds")
        ),
        Encoding("offset", "body frame 5.5 radii of gyration off the com", _away, needs_free=True),
        Encoding(
            "aligned",
            "a frame as far off and turned, with a free joint aligned with the inertia",
            _principal,
            Description(joint="aligned"),
            effects=OF_ONE_BODY,
            needs_free=True,
        ),
        Encoding(
            "mirrored",
            "world and body mirrored, x reversed",
            lambda _: SceneChange(is_mirrored=True),
            effects=ON_A_TABLE,
        ),
        Encoding(
            "mm-g",
            "in millimetres and grams",
            lambda _: SceneChange(length=1e3, mass=1e3),
            effects=ON_A_TABLE,
        ),
        Encoding("ms", "in milliseconds", lambda _: SceneChange(time=1e3), effects=ON_A_TABLE),
        Encoding(
            "compensated",
            "gravity, and its compensation",
            description=Description(compensated=True),
            effects=OF_BODIES - {"gravity"},
        ),
        Encoding(
            "slides-ball",
            "three slides and a ball joint, not a free joint",
            description=Description(joint="slides and ball"),
            effects=FREE_FALL,
            needs_free=True,
        ),
        Encoding(
            "hinges",
            "three hinges, not a ball joint; of a free body on three slides",
            description=Description(joint="hinges"),
            effects=frozenset({"gravity", "pivot"}),
        ),
        Encoding(
            "urdf",
            "the model as URDF, not in the engine's own language",
            description=Description(urdf=True),
            effects=FREE_FALL | {"pivot"},
        ),
    )
}
