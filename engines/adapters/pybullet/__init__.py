"""PyBullet, Bullet 3 in double precision, from the scene as URDF."""

from .engine import PyBullet

__all__ = ["PyBullet"]
