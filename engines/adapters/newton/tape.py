"""Derivatives of a world's steps by Warp's tape, which is reverse-mode differentiation.

As Newton's users do, `solver.step` is recorded and gradients are propagated backwards. A second
model is needed, whose arrays have gradients.
"""

from typing import Any

import newton
import numpy as np
import warp as wp
from spincheck.engine import FloatArray, in_chart, numbers_by_chart

from ...world_parts import is_pushed, matrix

#: Declared as `Any`, because Warp has no types.
TAPE: Any = wp.Tape
#: Indices in Warp's transform of the quaternion's w, x, y and z, which is stored as x y z w; and
#: indices of ω in a twist.
QUATERNION, TURNING = (6, 3, 4, 5), (3, 4, 5)


class Tape:
    """A second model of a world's scene: its arrays have gradients, and Warp's tape records steps.

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
        """Return the Jacobian, in the chart, of steps that start with a given motion, (6, 6).

        The chart's turns, rad, and ω, rad/s, are along the axes of the scene's record.

        Parameters
        ----------
        motion : the motion before the steps, a dict with `q`, `omega`, `com`, `velocity` and, with
            rotors, `spins` as in a scene record
        timestep : length of the steps, s
        steps : number of steps

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
        """Return the Jacobian of attitude and ω at the end by those at the start, (7, 7).

        Attitudes are quaternions, w x y z, and ω is in world axes.

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
        """Return a Jacobian in quaternions and ω_world, converted to the chart, (6, 6).

        The chart is a turn δθ and ω, both in body axes. If R is the attitude, ω_world is R ω, and
        δR is R [δθ]×.

        Parameters
        ----------
        motion : the motion before the steps, as `jacobian` takes it
        end : Newton's state after the steps
        rows : the Jacobian that is converted, (7, 7), from `_rows`
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
    """Return the matrix M, (3, 3), with M u = v × u for every vector u."""
    return np.asarray(np.cross(v, np.eye(3)).T)
