"""MuJoCo, from the scene as MJCF or URDF, and from users' own files."""

from .engine import MuJoCo
from .file_engine import MuJoCoFile
