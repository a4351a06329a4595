"""The plan of a run, which determines everything except the participant's answers."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from slipscale.experiments.languages.texts import Texts, load_texts
from slipscale.experiments.protocol_parts.base import (
    ORDER_VERSION,
    Context,
    Options,
    Protocol,
    protocol_texts,
)
from slipscale.experiments.protocol_parts.registry import load_protocol
from slipscale.experiments.protocol_parts.simulated_answers import SimulatedAnswer
from slipscale.experiments.steps.questions.base import CONSENT
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.replies import Answer, Reply
from slipscale.experiments.steps.steps import Ask, Instruct, Steps
from slipscale.experiments.study.factors import crossed
from slipscale.experiments.study.file import parse_study
from slipscale.experiments.study.headphone_test import HEADPHONES
from slipscale.experiments.study.model import Study
from slipscale.experiments.study.stroke import guided
from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.stimuli.headphone_sounds import NoiseInEar
from slipscale.stimuli.level_names import is_level

Mode = Literal["participant", "pilot"]


JOURNAL_NAME = re.compile(
    r"sub-(?P<participant>[A-Za-z0-9]+)(_ses-(?P<session>[A-Za-z0-9]+))?_run-(?P<run>[0-9]+)"
    r"_journal\.jsonl"
)


def check_labels(*, participant: str, session: str, run: str) -> None:
    """Raise `UserError` unless BIDS allows the labels; ``session`` may be empty."""
    if not re.fullmatch(r"[0-9]+", run):
        raise UserError("--run '{run}': expected a number, such as 01", run=run)
    for name, value in (("participant", participant), ("session", session)):
        if not re.fullmatch(r"[A-Za-z0-9]+", value) and (value or name != "session"):
            raise UserError(
                "--{name} '{value}': expected letters and digits only, such as 01 (never a "
                "participant's name)",
                name=name,
                value=value,
            )


def _last_number(label: str) -> int | None:
    """Return the number at the end of a label (1 for P01), or None if there is none."""
    found = re.search(r"[0-9]{1,18}$", label)
    return int(found[0]) if found else None


def stem(participant: str, session: str) -> str:
    """Return the prefix of a run's file names (BIDS entities)."""
    return f"sub-{participant}_ses-{session}" if session else f"sub-{participant}"


def journal_path(dataset: Path, *, participant: str, session: str, run: str) -> Path:
    """Return the path of a run's journal in a data set."""
    folder = dataset / "sourcedata" / f"sub-{participant}"
    return folder / f"{stem(participant, session)}_run-{run}_journal.jsonl"


@dataclass(frozen=True, slots=True, kw_only=True)
class RunPlan:
    """All values that determine a run, except the participant's answers.

    Parameters
    ----------
    study_name, study_text : str
        The study file's name and complete text, which the journal's first record contains.
    participant, session, run : str
        Labels that consist of letters and digits. ``session`` may be empty.
    seed : int
        The seed in the study file or, if given, on the command line.
    language : str
        Language of the text shown to the participant.
    mode : {"participant", "pilot"}
        Kind of run, stored so that a pilot cannot be mistaken for a participant's run.
    order_version : int
        Version of the rule that generates presentation orders. A run can be resumed only if the
        version is the same.
    population : str
        The `Population` that a pilot simulates (see
        `slipscale.experiments.participants.simulated_people.population`), as JSON with all
        parameters; empty for a participant's run.
    """

    study_name: str
    study_text: str
    participant: str
    session: str = ""
    run: str = "01"
    seed: int
    language: str
    mode: Mode
    order_version: int = ORDER_VERSION
    population: str = ""

    def __post_init__(self) -> None:
        if self.order_version != ORDER_VERSION:
            raise UserError(
                "this run has orders of version {order_version}, but this Slipscale generates "
                "version {own_version}; resume with the release that began the run",
                order_version=self.order_version,
                own_version=ORDER_VERSION,
            )
        if self.seed < 0:
            raise UserError("--seed {seed}: expected 0 or more", seed=self.seed)
        check_labels(participant=self.participant, session=self.session, run=self.run)

    @property
    def study(self) -> Study:
        """The parsed study."""
        return parse_study(self.study_text, self.study_name)

    @property
    def row(self) -> int:
        """The participant's position in the counterbalancing, from 0, derived from the label.

        The number at the end of the label determines the position. If the label does not end in a
        number, the position is derived from a hash of the label and is not balanced.
        """
        number = _last_number(self.participant)
        if number is not None:
            return max(number - 1, 0)
        return int.from_bytes(hashlib.sha256(self.participant.encode()).digest()[:4], "big")

    @property
    def visit(self) -> int:
        """The index of this run among the participant's planned runs, from 0.

        Raises
        ------
        UserError
            If the study defines sessions, but not this session.
        """
        study = self.study
        if study.sessions and self.session not in study.sessions:
            raise UserError(
                "--session '{session}': expected one of the study's sessions: {sessions}",
                session=self.session,
                sessions=", ".join(study.sessions),
            )
        session = (
            study.sessions.index(self.session)
            if study.sessions
            else max((_last_number(self.session) or 1) - 1, 0)
        )
        return session * study.runs + max((_last_number(self.run) or 1) - 1, 0)

    @property
    def stem(self) -> str:
        """The prefix of the run's file names (BIDS entities)."""
        return stem(self.participant, self.session)

    def journal_path(self, dataset: Path) -> Path:
        """Return the path of the run's journal in a data set."""
        return journal_path(
            dataset, participant=self.participant, session=self.session, run=self.run
        )

    def heading(self, plate: str) -> tuple[str, ...]:
        """Return the heading for the operator: participant, study and plate."""
        who = "participant {label}, run {run}"
        if self.session:
            who = "participant {label}, session {session}, run {run}"
        pilot = ("PILOT",) if self.mode == "pilot" else ()
        return (
            Message(who, label=self.participant, session=self.session, run=self.run),
            Message("study {study_name}", study_name=self.study.name),
            Message("plate {plate}", plate=plate),
            *pilot,
        )

    def texts(self) -> Texts:
        """Return the texts of screens and protocols in the run's language, by key.

        Raises
        ------
        UserError
            If a protocol of the study has no texts in the run's language.
        """
        brought: dict[str, str] = {}
        for options in self.study.tasks:
            protocol = load_protocol(options.protocol)
            brought |= protocol_texts(protocol, self.language)
        texts = load_texts(
            self.language,
            self.study.texts.get(self.language),
            brought,
            self.study.words_of(self.language),
        )
        return {**texts, **self.study.keys.texts()}

    def context(self, task: str = "") -> Context:
        """Return the context that is passed to a task's protocol."""
        return Context(
            seed=self.seed,
            participant=self.participant,
            row=self.row,
            levels=self.study.levels,
            quantity=self.study.quantity,
            texts=self.texts(),
            task=task,
            textures=self.study.texture_surfaces,
            varied=self.study.varied,
            visit=self.visit,
            advance=self.study.visits == "advance",
            session=self.session,
            run=self.run,
        )

    def tasks(self) -> list[tuple[Protocol, Options]]:
        """Return the tasks in this participant's order."""
        study = self.study
        tasks = [
            (
                crossed(
                    load_protocol(options.protocol).for_task(options),
                    study.factors,
                    plate=study.plate_quantity,
                    language=self.language,
                    second=study.second_plate,
                ),
                options,
            )
            for options in study.tasks
        ]
        turns = self.row + (self.visit if study.visits == "advance" else 0)
        turned = study.task_order == "counterbalanced" and turns % 2 == 1
        return tasks[::-1] if turned else tasks

    @property
    def trial_levels(self) -> list[str]:
        """The levels that trials can contain, as named in files: columns and options of tasks."""
        in_file = self.study.quantity.in_file
        return sorted(
            {
                in_file[name]
                for task, _ in self.tasks()
                for names in (task.design, task.stimulus, task.response, task.amplitudes)
                for name in names
                if is_level(name)
            }
        )

    def planned_trials(self) -> int:
        """Return the number of trials in the run if no trial is repeated."""
        return sum(
            protocol.trials(options, self.context(protocol.task))
            for protocol, options in self.tasks()
        )

    def simulated_answers(self) -> dict[tuple[str, str], SimulatedAnswer]:
        """Return the functions that answer a pilot's questions, keyed by task and question."""
        answers = {
            (protocol.task, name): answer
            for protocol, _ in self.tasks()
            for name, answer in protocol.simulated.items()
        }
        for questionnaire in self.study.questionnaires:
            answers |= questionnaire.simulated()
        if self.study.headphone_test:
            answers |= self.study.headphone_test.simulated()
        return answers

    def person_questions(self) -> list[Ask]:
        """Return the questions about the participant in the run's language.

        Items of questionnaires are only checked for missing texts.

        Raises
        ------
        UserError
            If a question or a questionnaire has no text in the run's language.
        """
        texts = self.texts()
        for questionnaire in self.study.questionnaires:
            questionnaire.asks(self.language, texts)
        return [question.ask(self.language, texts) for question in self.study.about_you]

    def steps(self) -> Steps:
        """Yield all steps of the run."""
        steps, study = self._steps(), self.study
        if study.stroke:
            steps = guided(steps, study.stroke, self.texts())
        return _spoken(steps) if study.keys.numbers == "spoken" else steps

    def _steps(self) -> Steps:
        texts, context = self.texts(), self.context()
        yield Instruct(title=texts["session.welcome_title"], text=texts["session.welcome"])
        if self.study.informed_consent:
            yield from _consent(texts)
        for question in self.person_questions():  # noqa: UP028  a list takes no answers
            yield question
        yield from self._questionnaires("before")
        yield from self._headphone_test()
        for protocol, options in self.tasks():
            yield from protocol.steps(options, replace(context, task=protocol.task))
        yield from self._questionnaires("after")
        yield Instruct(title=texts["session.thanks_title"], text=texts["session.thanks"], last=True)

    def _headphone_test(self) -> Steps:
        study = self.study
        if study.headphone_test is None:
            return
        noise = None
        if study.masking_noise:
            level_db = study.masking_noise.level_db
            noise = NoiseInEar(ear="both", level_db=level_db, seed=study.seed)
        context = self.context(HEADPHONES)
        yield from study.headphone_test.steps(context, context.texts, noise)

    def _questionnaires(self, when: str) -> Steps:
        for questionnaire in self.study.questionnaires:
            if questionnaire.when == when:
                yield from questionnaire.steps(self.language, self.texts())


def _spoken(steps: Steps) -> Steps:
    """Yield the steps; the operator types the answers to questions that ask for a number."""
    answer: Answer = None
    while True:
        try:
            step = steps.send(answer)
        except StopIteration:
            return
        if isinstance(step, Ask) and step.question.SPOKEN:
            step = replace(step, by="operator")
        answer = yield step


def _consent(texts: Texts) -> Steps:
    """Yield the consent text, then repeat the consent question until the participant agrees."""
    options = tuple((code, texts[f"session.consent_{code}"]) for code in ("yes", "no"))
    question = ChoiceQuestion(prompt=texts["session.consent_question"], options=options)
    yield Instruct(title=texts["session.consent_title"], text=texts["session.consent"])
    while isinstance(reply := (yield Ask(name=CONSENT, question=question)), Reply):
        if reply.value != "no":
            return
        yield Instruct(text=texts["session.consent_missing"])
