"""Provide the base class of tables in files, forms and messages."""

from typing import Any

from pydantic import BaseModel, ConfigDict, Field


class FrozenTable(BaseModel):
    """Immutable table that rejects unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def setting(
    default: Any,
    description: str,
    *,
    unit: str = "",
    validate_default: bool = False,
    **more: str | float,
) -> Any:
    """Declare an optional key of a table.

    Parameters
    ----------
    default
        The value if the key is omitted.
    description : str
        What the key means, for the reference of study files.
    unit : str
        The key's unit; empty if its name states it, or if it has none.
    validate_default : bool
        Whether the validators of the key also receive the default.
    **more
        Further properties of the key in the JSON schema.

    Returns
    -------
    FieldInfo
        Typed like the result of pydantic's ``Field``, which fits a field of any type.
    """
    extra: dict[str, Any] = {"unit": unit, **more} if unit else dict(more)
    return Field(
        default=default,
        description=description,
        json_schema_extra=extra or None,
        validate_default=validate_default or None,
    )
