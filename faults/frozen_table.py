"""Define the base class for tables that are read from files, forms and messages."""

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
        Value that is used if the key is omitted.
    description : str
        Meaning of the key, as shown in the documentation of study files.
    unit : str
        Unit of the key; empty if the key has no unit, or if its name contains the unit.
    validate_default : bool
        Whether the key's validators also check the default.
    **more
        Further properties of the key in the JSON schema.

    Returns
    -------
    FieldInfo
        Field of a pydantic model. The return type is ``Any``, so that it can be assigned to a field
        of any type.
    """
    extra: dict[str, Any] = {"unit": unit, **more} if unit else dict(more)
    return Field(
        default=default,
        description=description,
        json_schema_extra=extra or None,
        validate_default=validate_default or None,
    )
