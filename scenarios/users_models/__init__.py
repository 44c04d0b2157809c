"""Users' own models, URDF and MJCF: what a file states of its links, before any engine."""

from .mjcf import unnamed
from .model_file import IDENTITY, Format, Link, ModelFile, Pose, Shape, Stated, fused, welded
from .problems import WORLD, FileProblem, RigidBody, principal_moments, problems, rigid_bodies
from .read import check_origin, digest, read_model
from .xml_tree import ModelFileError
