"""Encodings: other descriptions of the same body and motion; engines must answer them alike."""

from .changed_scene import SceneChange
from .encoded_engine import SAME_BODY, EncodedEngine
from .table import ENCODINGS, Encoding
