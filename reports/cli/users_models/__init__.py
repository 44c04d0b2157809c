"""Commands about users' own models."""

from .model_commands import app

__all__ = ["app"]
