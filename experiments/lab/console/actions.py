"""The actions that a page can request, as a table of functions.

Pages refer to participants, runs and pilots by label, never by path. Labels are looked up among
those that exist. Each action returns the sentence that the page shows.
"""

from __future__ import annotations

import hashlib
import re
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipscale.experiments.dataset.backup import back_up, back_up_exclusions, not_backed_up
from slipscale.experiments.dataset.files import write_file
from slipscale.experiments.dataset.hand_exclusions import decide
from slipscale.experiments.dataset.withdrawal import sources_with, withdraw
from slipscale.experiments.journal.locks import is_being_written
from slipscale.experiments.journal.plan_and_progress import is_mock
from slipscale.experiments.lab.console.calibrating import made_calibration, measured_so_far
from slipscale.experiments.lab.console.forms import (
    TYPED,
    Acknowledge,
    Ask,
    Begin,
    Calibrate,
    Copy,
    Exclude,
    Form,
    Freeze,
    Nothing,
    Pilot,
    Reading,
    Resume,
    Settings,
    Study,
    Surface,
    Test,
    Unblind,
    Withdraw,
    Work,
    read_form,
)
from slipscale.experiments.lab.console.jobs import HELD, USING_THE_PLATE
from slipscale.experiments.lab.console.state import (
    PLANNING,
    ended_runs,
    export_folder,
    frozen_plans,
)
from slipscale.experiments.lab.folder import FILE, lab_text, read_lab, write_settings
from slipscale.experiments.lab.unblinding import unblind
from slipscale.experiments.running.run_state import studies
from slipscale.experiments.session.mailbox import LiveRequest, TrialName, post
from slipscale.experiments.study.file import parse_whole, shipped_studies, study_text
from slipscale.faults import UserError
from slipscale.hardware.cli.calibrate import without_calibration

if TYPE_CHECKING:
    from collections.abc import Callable

    from slipscale.experiments.lab.console.jobs import Job, Jobs
    from slipscale.experiments.lab.console.state import Snapshot, State
    from slipscale.experiments.lab.roster import Person


# What the sliders of planning choose from: less than a minute of computing.
GRID = (
    *("--participants", "6", "8", "12", "16", "20", "24", "32", "40"),
    *("--repetitions", "1", "2", "3", "--effect", "1", "0.75", "0.5", "--studies", "300"),
)


def unused(name: str, first: int = 1) -> Path:
    """Return a path that does not exist yet; ``name`` has a place for a number."""
    paths = (Path(name.format(number)) for number in count(first))
    return next(path for path in paths if not path.exists())


def power_folder(study_text: str) -> Path:
    """Return where the power of a study is kept: another text has another folder."""
    return PLANNING / f"power-{text_hash(study_text)[:12]}"


def text_hash(text: str) -> str:
    """Return a digest of a text, to check whether it is still the text that was shown."""
    return hashlib.sha256(text.encode()).hexdigest()


class Actions:
    """Carry out the actions that pages request.

    Parameters
    ----------
    state : State
    jobs : Jobs
    """

    def __init__(self, state: State, jobs: Jobs) -> None:
        self._state = state
        self._jobs = jobs
        self._warned: dict[tuple[str, str], None] = {}  # (session, sentence), in order
        self._acknowledged: set[tuple[str, str]] = set()
        self._analysed: frozenset[tuple[Path, int]] = frozenset()
        self._table: dict[str, tuple[type[Form], Callable[[Any], str]]] = {
            "begin": (Begin, self._begin),
            "resume": (Resume, self._resume),
            "ask": (Ask, self._ask),
            "check": (Nothing, self._check),
            "acknowledge": (Acknowledge, self._acknowledge),
            "settings": (Settings, self._settings),
            "test": (Test, self._test),
            "unblind": (Unblind, self._unblind),
            "analyse": (Nothing, self._analyse),
            "exclude": (Exclude, self._exclude),
            "withdraw": (Withdraw, self._withdraw),
            "work": (Work, self._work),
            "backup": (Nothing, self._backup),
            "calibrate": (Calibrate, self._calibrate),
            "conform": (Nothing, self._conform),
            "reading": (Reading, self._reading),
            "surface": (Surface, self._surface),
            "hold": (Nothing, self._hold),
            "release": (Nothing, self._release),
            "adopt": (Nothing, self._adopt),
            "emulator": (Nothing, self._emulator),
            "power": (Nothing, self._power),
            "freeze": (Freeze, self._freeze),
            "pilot": (Pilot, self._pilot),
            "save": (Study, self._save),
            "copy": (Copy, self._copy),
        }

    def do(self, name: str, sent: bytes) -> str:
        """Carry out an action; return the sentence to show.

        Raises
        ------
        UserError
            The action does not exist, the data sent do not fit it, or it is not possible now.
        """
        if name not in self._table:
            raise UserError("unknown action")
        form, action = self._table[name]
        return action(read_form(form, sent))

    def _now(self) -> Snapshot:
        """Return a fresh snapshot of the folder; raise `UserError` if the folder is unusable."""
        found = self._state.now(fresh=True)
        if found.problem:
            raise UserError(found.problem)
        return found

    def _free(self) -> Snapshot:
        """Return a fresh snapshot of the folder; raise `UserError` if anything uses the plate."""
        found = self._now()
        self._check_free(found)
        return found

    def _check_free(self, found: Snapshot) -> None:
        if found.live:
            raise UserError(f"a session of participant {found.live.label} is running; end it first")
        for kind in USING_THE_PLATE:
            job = self._jobs.last(kind)
            if job and job.running:
                raise UserError(f"{job.about}: still running; wait until it is finished")

    def _begin(self, asked: Begin) -> str:
        found = self._free()
        roster = found.rehearsals if asked.pilot else found.roster
        person = roster.person(asked.participant) if roster else None
        new = roster is not None and asked.participant == roster.new
        if not new and not (person and person.next_visit):
            raise UserError(
                f"participant {asked.participant} is no longer next; check the table again"
            )
        if is_mock(found.defaults.plate) and not asked.pilot:
            raise UserError(
                f"plate '{found.defaults.plate}' is simulated; participants cannot feel it. "
                "Set the real plate in slipscale.toml, or rehearse"
            )
        pilot = ("--pilot",) if asked.pilot else ()
        about = f"participant {asked.participant}"
        self._jobs.start(
            "session", about, "next", "--yes", "--participant", asked.participant, *pilot
        )
        return f"{about}: starting the session"

    def _resume(self, asked: Resume) -> str:
        found = self._free()
        roster = found.rehearsals if asked.pilot else found.roster
        person: Person | None = roster.person(asked.participant) if roster else None
        wanted = (asked.session, asked.run, "interrupted")
        for visit in person.visits if person else ():
            if (visit.session, visit.run, visit.state) == wanted:
                about = f"participant {asked.participant}"
                self._jobs.start("session", about, "resume", str(visit.path))
                return f"{about}: resuming the session"
        raise UserError(f"participant {asked.participant} has no such interrupted run")

    def _ask(self, asked: Ask) -> str:
        live = self._now().live
        if live is None or live.status is None or live.status.token != asked.token:
            raise UserError("that session is over")
        if asked.what in ("void", "note", "answer") and not asked.reason.strip():
            raise UserError("expected a text: a reason, a note, or the answer")
        if asked.what == "unblind":
            _check_meant(asked.word)
        about_trial = asked.what in ("void", "answer")
        trial = TrialName(task=asked.task, number=asked.trial) if about_trial else None
        post(
            live.visit.path,
            LiveRequest(
                token=asked.token,
                what=asked.what,
                reason=asked.reason.strip(),
                trial=trial,
                question=asked.question,
            ),
        )
        return f"request sent to the session: {asked.what.replace('_', ' ')}"

    def warnings(self) -> list[tuple[str, str]]:
        """Return the sessions' unacknowledged warnings as (session, sentence)."""
        live, job = self._state.now().live, self._jobs.last("session")
        if live and live.status:
            found = [(live.status.token, sentence) for sentence in live.status.warnings]
            self._warned |= dict.fromkeys(found)
        if job:
            self._warned |= dict.fromkeys((str(job.began_s), each) for each in job.warnings())
        return [each for each in tuple(self._warned) if each not in self._acknowledged]

    def _acknowledge(self, asked: Acknowledge) -> str:
        self._acknowledged.add((asked.session, asked.sentence))
        return ""

    def _settings(self, asked: Settings) -> str:
        self._check_free(self._state.now(fresh=True))  # works in a folder without settings, too
        if text_hash(lab_text(Path())) != asked.before:
            raise UserError(
                f"{FILE} was changed on disk after this page was loaded; reload the page, and "
                "make the change again"
            )
        write_settings(Path(), asked.settings)
        self._state.now(fresh=True)
        return f"saved: {FILE}"

    def _test(self, asked: Test) -> str:
        self._check_free(self._state.now(fresh=True))
        words = ("check", "--json", "--only", "plate", f"--plate={asked.plate}")
        self._jobs.start("test", "the test of the plate", *words)
        return "testing"

    def _check(self, _: Nothing) -> str:
        self._free()
        self._jobs.start("check", "the checklist", "check", "--json")
        return "checking"

    def _unblind(self, asked: Unblind) -> str:
        found = self._now()
        _check_meant(asked.word)
        if found.roster is None:
            raise UserError("there are no participants yet")
        unblind(found.defaults.data, found.roster)
        live = found.live
        if live and live.status and not live.pilot:
            words = "the operator asked the console to show results (unblinded)"
            post(live.visit.path, LiveRequest(token=live.status.token, what="note", reason=words))
        self._now()
        return "recorded: results are shown from now on"

    def _exclude(self, asked: Exclude) -> str:
        found = self._now()
        decide(
            found.defaults.out(pilot=asked.pilot),
            asked.participant,
            excluded=asked.excluded,
            reason=asked.reason,
            results_seen=found.seen,
        )
        back_up_exclusions(found.defaults.out(pilot=asked.pilot), asked.participant)
        self._now()
        done = "excluded" if asked.excluded else "included again"
        return (
            f"participant {asked.participant} is {done}; the next analysis takes this into account"
        )

    def _withdraw(self, asked: Withdraw) -> str:
        found = self._free()
        if asked.word.strip() != asked.participant:
            raise UserError(f"expected the participant's label, {asked.participant}")
        dataset = found.defaults.out(pilot=asked.pilot)
        gone = withdraw(dataset, asked.participant)
        self._now()
        left = "".join(
            f" {dataset} was merged from {source}, which may still contain their data: "
            "withdraw the participant there too."
            for source in sources_with(dataset, asked.participant)
        )
        return (
            f"participant {asked.participant} has withdrawn: {len(gone)} files and folders "
            "were removed or rewritten, including the results of all participants. Remove any "
            f"copies that you made elsewhere.{left}"
        )

    def _analyse(self, _: Nothing) -> str:
        found = self._now()
        if not found.seen:
            raise UserError(
                "results would unblind you: unblind first, or wait for all planned participants"
            )
        self._start_analysis(found)
        return "analysing"

    def _start_analysis(self, found: Snapshot) -> None:
        self._analysed = ended_runs(found)
        self._jobs.start("analysis", "the analysis", "analyse", "--steps", str(found.defaults.data))

    def renew(self) -> None:
        """Analyse again if runs have ended since the last analysis and results may be seen.

        No analysis starts while a session runs, so that the session can present its frames on
        time. A failed analysis is not repeated until another run has ended.
        """
        found = self._state.now()
        job = self._jobs.last("analysis")
        if not found.seen or found.live or (job and job.running):
            return
        ended = ended_runs(found)
        newest_ns = max((changed_ns for _, changed_ns in ended), default=0)
        # Analyses by other processes are known only by the modification time of their results.
        due = bool(self._analysed) or newest_ns > (found.results_ns or 0)
        if ended and ended != self._analysed and due:
            self._start_analysis(found)

    def _work(self, asked: Work) -> str:
        found = self._now()
        data = found.defaults.data
        if asked.what == "export" and not found.seen:
            raise UserError("the export contains results: unblind first, or wait for all planned")
        if found.live and not found.live.pilot:
            raise UserError(f"a session of participant {found.live.label} is running; end it first")
        words = {
            "verify": ("data", "verify", str(data), "--json"),
            "build": ("data", "build", str(data), "--json"),
            "export": ("export", str(data), "--out", str(export_folder(data))),
        }
        self._jobs.start(asked.what, f"data set: {asked.what}", *words[asked.what])
        return f"started: {asked.what}"

    def _backup(self, _: Nothing) -> str:
        found = self._now()
        data, folder = found.defaults.data, found.defaults.backup
        if folder is None:
            raise UserError("no backup folder is set; name one on the page Settings")
        missing = [
            journal for journal in not_backed_up(data, folder) if not is_being_written(journal)
        ]
        for journal in missing:
            back_up(data, journal, folder)
        self._now()
        return f"copied {len(missing)} runs to {folder}"

    def _calibrate(self, asked: Calibrate) -> str:
        found = self._free()
        words = [f"--by={asked.by}", f"--instrument={asked.instrument}"]
        numbers = ("temperature", "centre", "span", "sweep_voltage", "max_voltage")
        words += [
            f"--{name.replace('_', '-')}={typed.replace(',', '.')}"
            for name in numbers
            if (typed := getattr(asked, name))
        ]
        if asked.table == TYPED:
            words.append("--prompt")
        elif asked.table:
            if asked.table not in (path.name for path in Path().glob("*.csv")):
                raise UserError(f"{asked.table}: expected a CSV file of the laboratory folder")
            words += [f"--csv={asked.table}", f"--serial={asked.serial}"]
        if asked.finger:
            words.append("--finger")
        if asked.changed_plate:
            words.append("--changed-plate")
        spec = without_calibration(found.defaults.plate)
        out = ("--out", str(unused("calibration-{}.toml"))) if asked.keep else ("--measure-only",)
        words = ["plate", "calibrate", f"--plate={spec}", *words, *out, "--steps"]
        self._jobs.start("calibrate", "the calibration", *words)
        return "calibrating"

    def _reading(self, asked: Reading) -> str:
        job = self._jobs.last("calibrate")
        measured = measured_so_far(job.steps()) if job and job.running else None
        if job is None or measured is None or not measured.asked:
            raise UserError("no calibration is waiting for a reading")
        if len(measured.points) != asked.number:
            raise UserError("this point has its reading already; read the instrument again")
        job.type(asked.reading)
        return ""

    def _conform(self, _: Nothing) -> str:
        spec = self._free().defaults.plate
        self._jobs.start("conform", "the conformance check", "plate", "conform", spec)
        return "checking the plate's conformance"

    def _surface(self, asked: Surface) -> str:
        spec = self._free().defaults.plate
        words = ("plate", "watch", spec, f"--amplitude={asked.level:g}", "--every=0.2")
        self._jobs.start("surface", "the test surface", *words)
        return "presenting a test surface"

    def _held(self) -> list[Job]:
        jobs = (self._jobs.last(kind) for kind in HELD)
        return [job for job in jobs if job and job.running]

    def _hold(self, _: Nothing) -> str:
        for job in self._held():
            job.hold()
        return ""

    def _release(self, _: Nothing) -> str:
        for job in self._held():
            job.release()
        return "the plate is switched off"

    def _adopt(self, _: Nothing) -> str:
        self._free()
        job = self._jobs.last("calibrate")
        made, lab = made_calibration(job.said()) if job else "", read_lab(Path())
        if not made or lab is None:
            raise UserError("no calibration was made since this console was started")
        spec = without_calibration(lab.plate)
        spec += f"{',' if ':' in spec else ':'}calibration={made}"
        write_settings(Path(), lab.model_copy(update={"plate": spec}))
        self._now()
        return f"saved: the folder's plate uses {made}"

    def _emulator(self, _: Nothing) -> str:
        self._jobs.start("emulator", "the emulated board", "plate", "emulate")
        return "starting an emulated board"

    def _power(self, _: Nothing) -> str:
        found = self._now()
        out = power_folder(found.study_text)
        words = ("power", found.defaults.study, *GRID, "--steps", "--json", "--out", str(out))
        self._jobs.start("power", "the power", *words)
        return "computing"

    def _freeze(self, asked: Freeze) -> str:
        found = self._now()
        power = power_folder(found.study_text)
        told = {
            "--sample-size": asked.sample_size,
            "--existing-data": asked.existing_data,
            "--stopping": asked.stopping,
        }
        words = [f"{option}={text.strip()}" for option, text in told.items() if text.strip()]
        if (power / "power.json").is_file():
            words += ["--power", str(power)]
        PLANNING.mkdir(exist_ok=True)
        path = unused(f"{PLANNING}/plan-{{:03d}}.zip", len(frozen_plans()) + 1)
        study = found.defaults.study
        self._jobs.start("freeze", "the plan", "study", "freeze", study, "--out", str(path), *words)
        return f"freezing: {path}"

    def _pilot(self, asked: Pilot) -> str:
        self._now()
        numbers = ("--participants", str(asked.participants), "--seed", str(asked.seed))
        self._jobs.start("pilot", "the pilot", "pilot", *numbers, parts=asked.participants)
        return "the pilot is running"

    def _save(self, asked: Study) -> str:
        found = self._now()
        path = self._study_file(found)
        if text_hash(study_text(str(path))) != asked.before:
            raise UserError(
                f"{path}: was changed on disk after this page was loaded; copy your text, "
                "reload the page, and edit it again"
            )
        parse_whole(asked.text, str(path))
        write_file(path, asked.text)
        self._now()
        return f"saved: {path.name}"

    def _study_file(self, found: Snapshot) -> Path:
        """Return the study's file; raise `UserError` if it may not be edited."""
        if why := why_not_edited(found):
            raise UserError(why)
        return Path(found.defaults.study)

    def _copy(self, asked: Copy) -> str:
        self._now()
        path = Path(f"{asked.name}.toml")
        if path.exists() or asked.name in shipped_studies():
            raise UserError(f"{path}: already exists; choose another name")
        parse_whole(asked.text, path.name)
        label = re.sub("[^A-Za-z0-9]+", "_", asked.name)
        text = re.sub(r"(?m)^name\s*=.*$", f'name = "{label}"', asked.text, count=1)
        parse_whole(text, path.name)
        write_file(path, text)
        return f"wrote {path}; to use it, select it on the page Settings"


# The word to type to unblind, in the console's languages.
CONFIRMING = frozenset({"unblind", "voir"})


def _check_meant(word: str) -> None:
    if word.strip().casefold() not in CONFIRMING:
        raise UserError(f"expected the word {' or '.join(sorted(CONFIRMING))}")


def why_not_edited(found: Snapshot) -> str:
    """Return why the study's file cannot be edited here; empty if it can."""
    name = found.defaults.study
    if name in shipped_studies():
        return f"'{name}' comes with Slipscale: make a copy, and edit the copy"
    if found.study and found.study.name in studies(found.defaults.data):
        return f"'{name}' has data, which a changed study would no longer match; make a copy"
    return ""
