"""The data that pages send: one type per action. Anything else is rejected."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from slipscale.experiments.lab.folder import LabFile
from slipscale.faults import UserError
from slipscale.faults.validation import in_words
from slipscale.hardware.cli.calibrate import BACK

Label = Annotated[str, Field(pattern="^[A-Za-z0-9]{1,40}$")]
Words = Annotated[str, Field(max_length=2000)]
DECIMAL = r"[0-9]+([.,][0-9]*)?"
Decimal = Annotated[str, Field(pattern=f"^({DECIMAL})?$")]
TYPED = "typed"  # readings that the operator types, point by point
LARGEST_STUDY = 500_000


class Form(BaseModel):
    """Base of all forms; rejects unknown fields."""

    model_config = ConfigDict(frozen=True, extra="forbid")


FormType = TypeVar("FormType", bound=Form)


def read_form(form: type[FormType], sent: bytes) -> FormType:
    """Parse the data that a page sent; raise `UserError` if they do not fit the form."""
    try:
        return form.model_validate_json(sent)
    except ValidationError as error:
        raise UserError(in_words(error)) from None


class Begin(Form):
    """Begin a participant's session; ``participant`` is the label that the page showed as next."""

    participant: Label
    pilot: bool = False


class Resume(Form):
    """Resume an interrupted run."""

    participant: Label
    session: Annotated[str, Field(pattern="^[A-Za-z0-9]{0,40}$")]
    run: Label
    pilot: bool = False


class Ask(Form):
    """Send the running session a request that could also be made with a key."""

    token: Annotated[str, Field(pattern="^[0-9a-f]{1,64}$")]
    what: Literal[
        "pause", "go_on", "void", "ask_again", "retry", "stop", "note", "answer", "unblind"
    ]
    reason: Words = ""
    word: Words = ""
    task: Annotated[str, Field(max_length=100)] = ""
    trial: Annotated[int, Field(ge=0)] = 0
    question: Annotated[str, Field(max_length=100)] = ""


class Nothing(Form):
    """A form without fields."""


class Work(Form):
    """Start a job on the whole data set."""

    what: Literal["verify", "build", "export"]


class Freeze(Form):
    """What a registry asks for besides the study and its analysis; may be empty."""

    sample_size: Words = ""
    existing_data: Words = ""
    stopping: Words = ""


class Calibrate(Form):
    """Calibrate the folder's plate; without ``keep`` it is only measured.

    ``table`` names a CSV file of the folder with readings made elsewhere, and ``serial`` the device
    that drove the plate then; `TYPED` has the operator type each reading. The sweep's range is in
    Hz and in the calibration's V peak; what is left empty has the command's default.
    """

    by: Annotated[str, Field(min_length=1, max_length=200)]
    instrument: Annotated[str, Field(min_length=1, max_length=200)]
    temperature: Annotated[str, Field(pattern=f"^(-?{DECIMAL})?$")] = ""
    centre: Decimal = ""
    span: Decimal = ""
    sweep_voltage: Decimal = ""
    max_voltage: Decimal = ""
    finger: bool = False
    changed_plate: bool = False
    keep: bool = True
    table: Annotated[str, Field(max_length=200)] = ""
    serial: Annotated[str, Field(max_length=200)] = ""


class Reading(Form):
    """The instrument's reading in µm p-p, or what repeats the previous point.

    ``number`` is the count of readings before it, so that none is sent twice.
    """

    reading: Annotated[str, Field(pattern=f"^({DECIMAL}|{BACK})$")]
    number: Annotated[int, Field(ge=0)]


class Surface(Form):
    """Present a surface until the page lets go of it, ``level`` in the plate's quantity."""

    level: Annotated[float, Field(ge=0, allow_inf_nan=False)]


class Unblind(Form):
    """Unblind. ``word`` is typed by hand, so that a mistaken click does not unblind."""

    word: str


class Acknowledge(Form):
    """Acknowledge a session's warning."""

    session: str
    sentence: str


class Settings(Form):
    """The laboratory folder's new settings, and a digest of the file that the page showed."""

    settings: LabFile
    before: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]

    @field_validator("settings", mode="before")
    @classmethod
    def _listed(cls, value: Any) -> Any:
        """Split markers as they are typed, one per word."""
        if isinstance(value, dict) and isinstance(value.get("markers"), str):
            return value | {"markers": value["markers"].split()}
        return value


class Test(Form):
    """Test a plate before it is saved in the settings."""

    plate: Annotated[str, Field(min_length=1, max_length=300)]


class Pilot(Form):
    """Run a simulated pilot."""

    participants: Annotated[int, Field(ge=1, le=500)]
    seed: Annotated[int, Field(ge=0, le=2**31)]


class Study(Form):
    """A study's new text, and a digest of the text that the page showed before it was edited."""

    text: Annotated[str, Field(max_length=LARGEST_STUDY)]
    before: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


class Copy(Form):
    """Copy the study under another name."""

    name: Annotated[str, Field(pattern="^[A-Za-z][A-Za-z0-9_-]{0,60}$")]
    text: Annotated[str, Field(max_length=LARGEST_STUDY)]


class Exclude(Form):
    """Exclude a participant from the analysis, or include them again."""

    participant: Label
    excluded: bool
    reason: Words
    pilot: bool = False


class Withdraw(Form):
    """Remove a participant's data. ``word`` is the participant's label, typed by hand."""

    participant: Label
    word: Words
    pilot: bool = False
