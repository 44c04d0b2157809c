"""MuJoCo: scenes as MJCF or URDF, and links of users' own files."""

from .engine import MuJoCo
from .file_engine import MuJoCoFile
