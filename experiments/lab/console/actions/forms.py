"""Validate the data that console pages send with a request, and provide helpers for actions."""

from __future__ import annotations

import hashlib
from itertools import count
from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import Field, ValidationError

from slipscale.faults import UserError
from slipscale.faults.frozen_table import FrozenTable
from slipscale.faults.validation import in_words

Label = Annotated[str, Field(pattern="^[A-Za-z0-9]{1,40}$")]
Words = Annotated[str, Field(max_length=2000)]
Digest = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]  # hash of the text that the page showed
LARGEST_STUDY = 500_000


class Form(FrozenTable):
    """Base class for all forms, which rejects unknown fields."""


FormType = TypeVar("FormType", bound=Form)


def read_form(form: type[FormType], sent: bytes) -> FormType:
    """Parse the data that a page sends; raise `UserError` if the data do not match the form."""
    try:
        return form.model_validate_json(sent)
    except ValidationError as error:
        raise UserError(in_words(error)) from None


class Nothing(Form):
    """A form without fields."""


def text_hash(text: str) -> str:
    """Return a digest of a text, used to detect later changes."""
    return hashlib.sha256(text.encode()).hexdigest()


def unused(name: str, first: int = 1) -> Path:
    """Return the first unused path; ``name`` contains a placeholder for the number."""
    paths = (Path(name.format(number)) for number in count(first))
    return next(path for path in paths if not path.exists())
