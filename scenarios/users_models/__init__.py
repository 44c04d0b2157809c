"""Users' own models, URDF and MJCF: what a file states of its links, before any engine."""

from .errors import ModelFileError
from .model_file import Link, ModelFile, Shape, Stated, fused
from .problems import FileProblem, problems
from .read import read_model

__all__ = [
    "FileProblem",
    "Link",
    "ModelFile",
    "ModelFileError",
    "Shape",
    "Stated",
    "fused",
    "problems",
    "read_model",
]
