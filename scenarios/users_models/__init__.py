"""Users' own models, URDF and MJCF: what a file states of its links, before any engine."""

from .errors import ModelFileError
from .mjcf import unnamed
from .model_file import IDENTITY, Format, Link, ModelFile, Pose, Shape, Stated, fused, welded
from .origin import check_origin, digest
from .problems import FileProblem, principal_moments, problems
from .read import read_model
from .rigid_bodies import WORLD, RigidBody, rigid_bodies

__all__ = [
    "IDENTITY",
    "WORLD",
    "FileProblem",
    "Format",
    "Link",
    "ModelFile",
    "ModelFileError",
    "Pose",
    "RigidBody",
    "Shape",
    "Stated",
    "check_origin",
    "digest",
    "fused",
    "principal_moments",
    "problems",
    "read_model",
    "rigid_bodies",
    "unnamed",
    "welded",
]
