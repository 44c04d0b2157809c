"""Sessions of an honest engine but for one change of its physics."""

import numpy as np
from stepped import Stepped


class Ungyroscopic(Stepped):
    """There is no torque ω × Iω."""

    def torque(self):
        return np.cross(self.omega, self.inertia @ self.omega)


class Damped(Stepped):
    """Damped at 0.04 /s, as Bullet's rigid bodies by default."""

    def torque(self):
        return -0.04 * (self.inertia @ self.omega)


class UngyroscopicAndDamped(Stepped):
    """Both."""

    def torque(self):
        return Ungyroscopic.torque(self) + Damped.torque(self)
