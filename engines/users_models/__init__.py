"""Users' models (URDF, MJCF, USD): the links that a file states, and the bodies engines make."""

from .compare import AGREES, BodyDifference, cause, compared, difference, unstated_body
from .edit import elements_of, set_attributes, write_inertia
from .file_engine import Advice, Configuration, FileEngine, ModelReader
from .file_problems import FileProblem, problems, problems_of_parts, shapes_box
from .layout import MESHES, laid_out
from .model_file import (
    WORLD,
    Link,
    ModelFile,
    RigidBody,
    Shape,
    Span,
    Stated,
    principal_moments,
    rigid_bodies,
)
from .read import UsersLink, read_model, users_link
from .urdf import body_alone, edited
from .xml_tree import Element, ModelFileError, parse_xml
