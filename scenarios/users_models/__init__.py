"""Users' own models, URDF and MJCF: what a file states of its links, before any engine."""

from .errors import ModelFileError
from .mjcf import unnamed
from .model_file import Format, Link, ModelFile, Pose, Shape, Stated, fused, welded
from .origin import check_origin
from .problems import FileProblem, principal_moments, problems
from .read import read_model
from .scenes import LinkScene, link_scenes

__all__ = [
    "FileProblem",
    "Format",
    "Link",
    "LinkScene",
    "ModelFile",
    "ModelFileError",
    "Pose",
    "Shape",
    "Stated",
    "check_origin",
    "fused",
    "link_scenes",
    "principal_moments",
    "problems",
    "read_model",
    "unnamed",
    "welded",
]
