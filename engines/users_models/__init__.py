"""Users' models in engines: read, run, and compared with what the file states."""

from .cause import Kind, cause, unstated_body
from .difference import AGREES, BodyDifference, difference
from .file_engine import FileEngine, model_readers
from .model_reader import Advice, Configuration, ModelReader, RefusalAdvice
from .named_link import UsersLink, users_link
from .users_urdf import body_alone, with_meshes
