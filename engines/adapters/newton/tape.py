"""Derivatives of a world's steps by Warp's tape, in a model of its own whose arrays have gradients.

Newton's users record `solver.step` and propagate backwards from what they want differentiated.
"""

from typing import Any

import newton
import numpy as np
import warp as wp
from spincheck.engine import FloatArray, in_chart, numbers_by_chart

from ...world_parts import is_pushed, matrix

#: Imported as `Any`, because Warp has no types.
TAPE: Any = wp.Tape
#: Where a transform has the attitude, in the order w x y z although it is stored as x y z w, and
#: where a twist has ω.
QUATERNION, TURNING = (6, 3, 4, 5), (3, 4, 5)


class Tape:
    """A second model of a world's scene, with gradients, whose steps Warp's tape records.

    Parameters
    ----------
    world : a `World` of the adapter's stand-alone module
    """

    def __init__(self, world: Any) -> None:
        builder = world.builder()
        world.add_scene(builder, world.scene)
        builder.color()
        self._world, self._model = world, builder.finalize(requires_grad=True)
        self._solver = world.solver_class(self._model, **world.options)

    def jacobian(self, motion: Any, timestep: float, steps: int) -> FloatArray:
        """Return the Jacobian of steps from a motion by a turn and ω, axes of the record, (6, 6).

        Parameters
        ----------
        motion : the motion before the steps, keyed as in the scene's record
        timestep : s

        Raises
        ------
        NotImplementedError
            If the solver does not accept a model with gradients.
        """
        model = self._model
        start, *others = states = [model.state() for _ in range(steps + 1)]
        q, qd = self._world.coordinates(self._world.scene, motion)
        start.joint_q.assign(np.array(q, dtype=np.float32))
        start.joint_qd.assign(np.array(qd, dtype=np.float32))
        control, tape = model.control(), TAPE()
        with tape:
            newton.eval_fk(model, start.joint_q, start.joint_qd, start)
            for now, then in zip(states, others, strict=False):
                if is_pushed(self._world.scene):
                    self._world.push(now)
                self._solver.step(now, then, control, None, timestep)
        return self._in_chart(motion, states[-1], self._rows(tape, start, states[-1]))

    def _rows(self, tape: Any, start: Any, end: Any) -> FloatArray:
        """Return the Jacobian of the end's attitude and ω by those of the start, (7, 7).

        Attitudes are quaternions, w x y z, and ω is along world axes.

        Parameters
        ----------
        tape : Warp's tape, on which the steps are recorded
        start, end : Newton's states before and after the steps
        """
        is_free = self._world.scene["arm"] is None
        of_q = np.array(QUATERNION) - (0 if is_free else 3)
        of_qd = np.array(TURNING) - (0 if is_free else 3)
        rows = []
        wanted = [(end.body_q, place) for place in QUATERNION]
        for array, place in wanted + [(end.body_qd, place) for place in TURNING]:
            seed = np.zeros_like(array.numpy())
            seed[0, place] = 1.0
            tape.zero()
            tape.backward(grads={array: wp.array(seed, dtype=array.dtype)})
            by_q, by_qd = start.joint_q.grad.numpy(), start.joint_qd.grad.numpy()
            rows.append([*by_q[of_q], *by_qd[of_qd]])
        return np.array(rows, dtype=float)

    def _in_chart(self, motion: Any, end: Any, rows: FloatArray) -> FloatArray:
        """Return the Jacobian in the chart, (6, 6), given one of quaternions and ω_world, (7, 7).

        The chart is a turn δθ and ω in body axes: ω_world is R ω, and δR is R [δθ]×.

        Parameters
        ----------
        motion : the motion before the steps
        end : Newton's state after them
        rows : the Jacobian from `_rows`
        """
        q, q_after = np.array(motion["q"]), end.body_q.numpy()[0, list(QUATERNION)].astype(float)
        R, R_after = matrix(q), matrix(q_after)
        before = numbers_by_chart(q)
        before[4:] = np.hstack([-R @ _cross(R.T @ motion["omega"]), R])
        after = in_chart(q_after, rows @ before)
        omega_after = R_after.T @ end.body_qd.numpy()[0, list(TURNING)].astype(float)
        after[3:] = R_after.T @ after[3:] + _cross(omega_after) @ after[:3]
        return after


def _cross(v: FloatArray) -> FloatArray:
    """Return the matrix M with M u = v × u, (3, 3)."""
    return np.asarray(np.cross(v, np.eye(3)).T)
