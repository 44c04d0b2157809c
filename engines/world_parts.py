"""What the stand-alone modules of adapters share, written out with them: numpy alone."""

from typing import Any

import numpy as np

from ..scenarios.effects.push import is_pushed as is_pushed
from ..scenarios.effects.push import push as push


def matrix(q: Any) -> Any:
    """Rotation matrix of a quaternion w x y z, (3, 3)."""
    w, x, y, z = q
    n = w * w + x * x + y * y + z * z
    return np.eye(3) + 2 / n * np.array(
        [
            [-y * y - z * z, x * y - w * z, x * z + w * y],
            [x * y + w * z, -x * x - z * z, y * z - w * x],
            [x * z - w * y, y * z + w * x, -x * x - y * y],
        ]
    )
