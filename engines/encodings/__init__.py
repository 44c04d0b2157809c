"""Encodings: other descriptions of the same body and motion, from which engines must agree."""

from .changed_scene import SceneChange
from .encoded_engine import SAME_BODY, EncodedEngine
from .table import ENCODINGS, Encoding
