"""PyBullet, Bullet 3 in double precision, from the scene as URDF and from users' own files."""

from .engine import PyBullet
from .file_engine import PyBulletFile
