"""The base of every table that a file, a form or a message states."""

from pydantic import BaseModel, ConfigDict


class FrozenTable(BaseModel):
    """A table that cannot be changed; an unknown key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid")
