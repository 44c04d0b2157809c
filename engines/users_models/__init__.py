"""Users' models, URDF and MJCF: what a file states of its links, and what engines hold of them."""

from .compare import AGREES, BodyDifference, cause, difference, unstated_body
from .file_engine import Advice, Configuration, FileEngine, ModelReader, model_readers
from .file_problems import FileProblem, problems
from .mjcf import unnamed
from .model_file import (
    WORLD,
    Link,
    ModelFile,
    RigidBody,
    Shape,
    Stated,
    principal_moments,
    rigid_bodies,
)
from .read import UsersLink, read_model, users_link
from .urdf import body_alone, mesh_bytes, with_meshes
from .xml_tree import ModelFileError
