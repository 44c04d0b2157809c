"""Reads figures as the page's script and Plotly do."""

import base64
from typing import Any

import numpy as np
from spincheck.reports.pages.figures.plot import GROUND, INK, WIRE
from spincheck.scenarios import FloatArray


def values_of(spec: dict[str, str]) -> FloatArray:
    return np.frombuffer(base64.b64decode(spec["bdata"]), dtype="<f4")


def coloured(value: Any) -> Any:
    """A figure as the page's script completes it; what it draws from the motions is left out."""
    if isinstance(value, dict):
        return {name: coloured(item) for name, item in value.items() if name != "overlays"}
    if isinstance(value, list):
        return [coloured(item) for item in value]
    return "#123456" if value in (INK, WIRE, GROUND) else value
