"""The base class of every table in a file, a form or a message."""

from pydantic import BaseModel, ConfigDict


class FrozenTable(BaseModel):
    """A table that cannot be changed; an unknown key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid")
