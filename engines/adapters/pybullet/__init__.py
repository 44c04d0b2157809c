"""PyBullet, Bullet 3 in double precision: scenes as URDF, and links of users' own files."""

from .engine import PyBullet
from .file_engine import PyBulletFile
