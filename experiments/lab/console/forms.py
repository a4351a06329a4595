"""What pages send: one type per action; anything else is refused."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator

from slipscale.experiments.lab.folder import LabFile

Label = Annotated[str, Field(pattern="^[A-Za-z0-9]{1,40}$")]
Words = Annotated[str, Field(max_length=2000)]
LARGEST_STUDY = 500_000


class Form(BaseModel):
    """What a page sends; anything else is refused."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Begin(Form):
    """Begin a participant's session: ``participant`` is who the page said is next."""

    participant: Label
    pilot: bool = False


class Resume(Form):
    """Go on with an interrupted run."""

    participant: Label
    session: Annotated[str, Field(pattern="^[A-Za-z0-9]{0,40}$")]
    run: Label
    pilot: bool = False


class Ask(Form):
    """Ask the running session for what a key would."""

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
    """Nothing needs to be said."""


class Unblind(Form):
    """``word`` is typed by hand: a click by mistake does not unblind."""

    word: str


class Acknowledge(Form):
    """Somebody has read a session's warning."""

    session: str
    sentence: str


class Settings(Form):
    """The laboratory folder's settings, and the file's text that the page showed."""

    settings: LabFile
    before: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]

    @field_validator("settings", mode="before")
    @classmethod
    def _listed(cls, value: Any) -> Any:
        """Take markers as they are typed: one word each."""
        if isinstance(value, dict) and isinstance(value.get("markers"), str):
            return value | {"markers": value["markers"].split()}
        return value


class Test(Form):
    """Try a plate before it is written down."""

    plate: Annotated[str, Field(min_length=1, max_length=300)]


class Pilot(Form):
    """Run a simulated pilot."""

    participants: Annotated[int, Field(ge=1, le=500)]
    seed: Annotated[int, Field(ge=0, le=2**31)]


class Study(Form):
    """A study's new text, and what the page was shown before it was edited."""

    text: Annotated[str, Field(max_length=LARGEST_STUDY)]
    before: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


class Copy(Form):
    """A copy of the study under another name."""

    name: Annotated[str, Field(pattern="^[A-Za-z][A-Za-z0-9_-]{0,60}$")]
    text: Annotated[str, Field(max_length=LARGEST_STUDY)]


class Exclude(Form):
    """Exclude a participant from the analysis by hand, or include them again."""

    participant: Label
    excluded: bool
    reason: Words
    pilot: bool = False


class Withdraw(Form):
    """Remove a participant's data; ``word`` is their label, typed by hand."""

    participant: Label
    word: Words
    pilot: bool = False
