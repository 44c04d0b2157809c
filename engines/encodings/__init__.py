"""The same body and motion described otherwise: what engines must answer alike."""

from .changed_scene import SceneChange
from .encoded_engine import SAME_BODY, EncodedEngine
from .table import ENCODINGS, Encoding
