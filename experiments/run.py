"""A run: one participant through a study's tasks, from the welcome to the thank-you."""

from __future__ import annotations

import hashlib
import platform
import re
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from experiments.journal import FORMAT, read_records
from experiments.protocols.base import Context, load_protocol
from experiments.session import Session
from experiments.steps import Ask, ChoiceQuestion, Instruct, Steps
from experiments.study import parse_study, study_hash
from experiments.texts import load_texts
from faults import UserError

if TYPE_CHECKING:
    from experiments.journal import Journal, Record
    from experiments.noise import Noise
    from experiments.operator import Operator
    from experiments.participants.base import Participant
    from experiments.protocols.base import Options, Protocol
    from experiments.session import Outcome
    from experiments.study_model import Study
    from experiments.texts import Texts
    from hardware.clock import Clock
    from hardware.driver import PlateDriver

Mode = Literal["participant", "pilot"]
PACKAGES = ("slipscale", "numpy", "psychopy")


def check_labels(*, participant: str, session: str, run: str) -> None:
    """Raise `UserError` unless these can be parts of file names; ``session`` may be empty."""
    for name, value in (("participant", participant), ("run", run), ("session", session)):
        if not re.fullmatch(r"[A-Za-z0-9]+", value) and (value or name != "session"):
            raise UserError(
                f"--{name} '{value}': expected letters and digits only, such as 01 "
                "(never a participant's name)"
            )


def stem(participant: str, session: str) -> str:
    """Return the beginning of a run's file names (BIDS entities)."""
    return f"sub-{participant}_ses-{session}" if session else f"sub-{participant}"


def journal_path(dataset: Path, *, participant: str, session: str, run: str) -> Path:
    """Return where a run's journal lies in a data set."""
    folder = dataset / "sourcedata" / f"sub-{participant}"
    return folder / f"{stem(participant, session)}_run-{run}_journal.jsonl"


@dataclass(frozen=True, slots=True, kw_only=True)
class RunPlan:
    """Everything that decides what happens in a run, but for the participant's answers.

    Parameters
    ----------
    study_name, study_text : str
        The study file's name and text, kept whole in the journal's first record.
    participant, session, run : str
        Labels: letters and digits. ``session`` may be empty.
    seed : int
        The study's, unless the command named another.
    language : str
        What the participant reads.
    mode : {"participant", "pilot"}
        Told in every record, so that a pilot can never pass for a person.
    """

    study_name: str
    study_text: str
    participant: str
    session: str = ""
    run: str = "01"
    seed: int
    language: str
    mode: Mode

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise UserError(f"--seed {self.seed}: expected 0 or more")
        check_labels(participant=self.participant, session=self.session, run=self.run)

    @property
    def study(self) -> Study:
        """The study, parsed."""
        return parse_study(self.study_text, self.study_name)

    @property
    def row(self) -> int:
        """The place in the counterbalancing: the participant's number, from 0."""
        if self.participant.isdigit():
            return max(int(self.participant) - 1, 0)
        return int.from_bytes(hashlib.sha256(self.participant.encode()).digest()[:4], "big")

    @property
    def stem(self) -> str:
        """The beginning of the run's file names (BIDS entities)."""
        return stem(self.participant, self.session)

    def journal_path(self, dataset: Path) -> Path:
        """Return where the run's journal lies in a data set."""
        return journal_path(
            dataset, participant=self.participant, session=self.session, run=self.run
        )

    def texts(self) -> Texts:
        """Return what the participant reads."""
        return load_texts(self.language, self.study.texts.get(self.language))

    def context(self) -> Context:
        """Return what the protocols know of the run."""
        return Context(
            seed=self.seed,
            participant=self.participant,
            row=self.row,
            amplitudes_um_pp=self.study.amplitudes_um_pp,
            texts=self.texts(),
            textures=self.study.gratings,
        )

    def tasks(self) -> list[tuple[Protocol, Options]]:
        """Return the tasks in the order in which this participant has them."""
        study = self.study
        tasks = [(load_protocol(options.protocol), options) for options in study.tasks]
        turned = study.task_order == "counterbalanced" and self.row % 2 == 1
        return tasks[::-1] if turned else tasks

    def planned_trials(self) -> int:
        """Return how many trials the run will have if none is repeated."""
        context = self.context()
        return sum(protocol.trials(options, context) for protocol, options in self.tasks())

    def steps(self) -> Steps:
        """Yield all steps of the run."""
        texts, context = self.texts(), self.context()
        yield Instruct(title=texts["session.welcome_title"], text=texts["session.welcome"])
        for question in self.study.about_you:
            choices = tuple((words, words) for words in question.options)
            prompt = question.prompt or texts[f"about_you.{question.name}"]
            yield Ask(name=question.name, question=ChoiceQuestion(prompt=prompt, options=choices))
        for protocol, options in self.tasks():
            yield from protocol.steps(options, context)
        yield Instruct(title=texts["session.thanks_title"], text=texts["session.thanks"], last=True)


def header(
    plan: RunPlan, plate: PlateDriver, spec: str, answered_by: str, masking: str
) -> dict[str, Any]:
    """Return the journal's first record: all that is needed to go on, or to analyse, without us."""
    return {
        "format": FORMAT,
        **asdict(plan),
        "answered_by": answered_by,
        "masking_noise": masking,
        "study_hash": study_hash(plan.study_text),
        "plate_spec": spec,
        "plate": plate.describe(),
        "software": software(),
        "started_utc": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def software() -> dict[str, str]:
    """Return the versions of what a run's data can depend on, without importing it."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found


def plan_from(record: Record) -> RunPlan:
    """Return the plan that a journal's header holds."""
    fields = RunPlan.__dataclass_fields__
    return RunPlan(**{name: record.data[name] for name in fields})


def read_plan(path: Path) -> tuple[RunPlan, list[Record]]:
    """Return a journal's plan and records; UserError unless it is a run's."""
    records, _ = read_records(path)
    if not records:
        raise UserError(f"journal {path}: holds nothing; begin the run anew with slipscale run")
    return plan_from(records[0]), records


def dataset_of(path: Path, plan: RunPlan) -> Path:
    """Return the folder of the data set that a journal lies in.

    Raises
    ------
    UserError
        The journal was renamed, or lies outside a data set: what it says and where it lies differ.
    """
    whole = path.resolve()
    expected = plan.journal_path(Path("DATASET"))
    if whole.parts[-3:] == expected.parts[-3:]:
        return whole.parent.parent.parent
    raise UserError(
        f"journal {path}: was written as {expected}; put it back under that name and folder"
    )


def is_mock(spec: str) -> bool:
    """Return whether a plate exists only as its physics: nobody feels anything there."""
    return spec.partition(":")[0] == "mock"


def last_plate(records: list[Record]) -> str:
    """Return the SPEC of the plate that a run was last on."""
    specs = [r.data["plate_spec"] for r in records if r.kind in ("header", "resume")]
    return str(specs[-1])


def answered_by(records: list[Record]) -> str:
    """Return who answered: "person", "simulated" or "scripted"."""
    return str(records[0].data["answered_by"])


def elapsed_s(records: list[Record]) -> float:
    """Return how far a run had come: the session's time at its last step."""
    return max((r.time_s for r in records if r.kind in ("header", "begin", "done")), default=0.0)


def is_complete(records: list[Record]) -> bool:
    """Return whether a run went on to its end."""
    return any(record.kind == "end" for record in records)


def perform(
    plan: RunPlan,
    *,
    spec: str,
    plate: PlateDriver,
    participant: Participant,
    journal: Journal,
    clock: Clock,
    operator: Operator,
    noise: Noise | None = None,
    unblind: bool = False,
) -> Outcome:
    """Run a plan from the journal's end to the run's.

    Parameters
    ----------
    plate : PlateDriver
        Connected.
    journal : Journal
        New (it gets its header here) or reopened.
    """
    masking = "on" if noise else "absent"
    if not journal.records:
        journal.write("header", **header(plan, plate, spec, participant.kind, masking))
    else:
        journal.write(
            "resume",
            plate_spec=spec,
            plate=plate.describe(),
            masking_noise=masking,
            software=software(),
        )
    session = Session(
        steps=plan.steps(),
        plate=plate,
        participant=participant,
        journal=journal,
        clock=clock,
        operator=operator,
        texts=plan.texts(),
        planned=plan.planned_trials(),
        noise=noise,
        unblind=unblind,
    )
    return session.run()
