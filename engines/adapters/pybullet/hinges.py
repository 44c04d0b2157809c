"""Rotors of a body in PyBullet: links on hinges, which its base or its hung link carries."""

from dataclasses import dataclass
from typing import cast

import numpy as np
import pybullet as p
from numpy.typing import NDArray

from ....scenarios import FloatArray

#: N m, of a drive; none needs so much.
UNREACHED_TORQUE = 1e100


@dataclass(frozen=True, eq=False)
class Hinges:
    """The rotors of a scene, those on locked hinges included, which are fixed links.

    Attributes
    ----------
    client, body : PyBullet's numbers for the world and the body in it
    first : its number of the first rotor's link; the others follow
    is_turning, is_driven : of each rotor, (rotors,)
    """

    client: int
    body: int
    first: int
    is_turning: NDArray[np.bool_]
    is_driven: NDArray[np.bool_]

    @property
    def links(self) -> list[int]:
        """Those that turn, by PyBullet's numbers."""
        return [self.first + int(k) for k in np.flatnonzero(self.is_turning)]

    def read(self) -> tuple[float, ...]:
        """The spins of those that turn, relative to the body, rad/s."""
        states = p.getJointStates(self.body, self.links, self.client)
        return tuple(cast(float, state[1]) for state in states)

    def spins(self, read: FloatArray) -> FloatArray:
        """The spins of all, (n, rotors), from n readings."""
        spins = np.zeros((len(read), len(self.is_turning)))
        spins[:, self.is_turning] = read
        return spins

    def set(self, spins: FloatArray) -> None:
        """Set the spins of all, rad/s, (rotors,), at the angles of the model, and the drives."""
        for rotor, spin in enumerate(spins):
            link = self.first + rotor
            if not self.is_turning[rotor]:
                continue
            p.resetJointState(self.body, link, 0.0, float(spin), self.client)
            if self.is_driven[rotor]:
                self._motor(link, float(spin), UNREACHED_TORQUE)

    def take_away_motors(self) -> None:
        """Remove PyBullet's motors, which brake every hinge."""
        for link in self.links:
            self._motor(link, 0.0, 0.0)

    def _motor(self, link: int, spin: float, torque: float) -> None:
        p.setJointMotorControl2(
            self.body,
            link,
            p.VELOCITY_CONTROL,
            targetVelocity=spin,
            force=torque,
            physicsClientId=self.client,
        )

    def axes(self) -> list[FloatArray]:
        """The axes of the hinges that turn, along the principal axes of their links, (3,) each."""
        return [np.array(p.getJointInfo(self.body, k, self.client)[13]) for k in self.links]
