"""The base of all tables of a scenario file."""

from pydantic import BaseModel, ConfigDict


class Table(BaseModel):
    """A table of the file: immutable, and closed to unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")
