"""Bodies in MuJoCo Warp, which needs `mujoco`, `mujoco-warp`, `warp-lang` and numpy alone."""

from dataclasses import fields, is_dataclass

import mujoco
import mujoco_warp as mjw
import numpy as np
import warp as wp

wp.config.log_level = wp.LOG_ERROR
wp.set_device("cpu")


class FirstWorld:
    """A view of MuJoCo Warp's model or data that looks like MuJoCo's, with arrays of numpy.

    Of arrays with a row for each world, the view has the first world's row. A field that MuJoCo
    Warp does not have is read from MuJoCo's own object.

    Parameters
    ----------
    on_device : MuJoCo Warp's model, data, or options of a model
    compiled : MuJoCo's own object of the same kind
    """

    def __init__(self, on_device, compiled):
        self.on_device, self.compiled = on_device, compiled

    def __getattr__(self, name):
        compiled = getattr(self.compiled, name)
        found = getattr(self.on_device, name, compiled)
        if name == "opt":
            return FirstWorld(found, compiled)
        if not isinstance(found, wp.array):
            return found
        numbers = found.numpy()
        return numbers[0] if numbers.ndim > np.ndim(compiled) else numbers


def in_warp(compiled, worlds):
    """Return MuJoCo Warp's model for several worlds.

    A field that may differ between worlds in MuJoCo Warp, such as a mass, has a row for each world
    if the compiled models differ in it. All other fields are those of the first compiled model.

    Parameters
    ----------
    compiled : MuJoCo's models
    worlds : index, in `compiled`, of the model of each world
    """
    first, *others = (mjw.put_model(one) for one in compiled)
    for field in fields(mjw.Model):
        array = getattr(first, field.name)
        if isinstance(array, wp.array) and field.type.shape[0] == "*":
            numbers = [array.numpy(), *(getattr(one, field.name).numpy() for one in others)]
            if any(not np.array_equal(numbers[0], other) for other in numbers):
                each = wp.array(np.concatenate(numbers)[worlds], dtype=array.dtype)
                setattr(first, field.name, each)
    return first


def arrays_of(data):
    """Yield the non-empty arrays in MuJoCo Warp's data, also those in dataclasses that it holds."""
    for field in fields(data):
        value = getattr(data, field.name)
        if is_dataclass(value):
            yield from arrays_of(value)
        elif isinstance(value, wp.array) and value.size:
            yield value


class World:
    """Worlds that MuJoCo Warp steps together.

    Parameters
    ----------
    compiled : MuJoCo's models
    worlds : index, in `compiled`, of the model of each world
    timestep : length of the steps, s
    qpos : coordinates at the start, (worlds, nq)
    qvel : velocities at the start, (worlds, nv)
    """

    def __init__(self, compiled, worlds, timestep, qpos, qvel):
        self.on_device = in_warp(compiled, worlds)
        self.there = mjw.make_data(compiled[0], nworld=len(worlds))
        self.unstepped = [(array, wp.clone(array)) for array in arrays_of(self.there)]
        self.model = FirstWorld(self.on_device, compiled[0])
        self.at_rest = mujoco.MjData(compiled[0])
        self.set_timestep(timestep)
        mjw.step(self.on_device, self.there)  # loads the kernels, impossible while recording
        with wp.ScopedCapture() as capture:
            mjw.step(self.on_device, self.there)
        self.graph = capture.graph
        self.restart(qpos, qvel)

    def set_timestep(self, timestep):
        """Set the length of the steps from now on, s."""
        self.on_device.opt.timestep.fill_(timestep)

    def restart(self, qpos, qvel):
        """Set coordinates, (worlds, nq), and velocities, (worlds, nv); earlier steps are forgotten.

        `mjw.reset_data` does the same, but takes 0.2 s, since it hashes kernels in each call.
        """
        for array, unstepped in self.unstepped:
            wp.copy(array, unstepped)
        with np.errstate(over="ignore"):
            self.there.qpos.assign(np.atleast_2d(qpos).astype(np.float32))
            self.there.qvel.assign(np.atleast_2d(qvel).astype(np.float32))

    def advance(self, steps):
        """Take `steps` steps by replaying a recorded one, a hundred times as fast as `mjw.step`."""
        for _ in range(steps):
            wp.capture_launch(self.graph)
        wp.synchronize_device()  # waits until a GPU has taken the steps

    def motions(self, places):
        """Return an array with qpos and then qvel of one world in each row, (n, nq + nv).

        `places` has the indices of the n worlds.
        """
        return np.concatenate([self.there.qpos.numpy(), self.there.qvel.numpy()], axis=1)[places]

    def data(self):
        """Return a view of the first world's data, with the field names of `mujoco.MjData`."""
        return FirstWorld(self.there, self.at_rest)
