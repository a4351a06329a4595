"""Analyse, verify, export and back up the data; exclude or withdraw participants; unblind."""

from __future__ import annotations

from typing import Literal

from slipscale.experiments.dataset.backup import back_up, back_up_exclusions, not_backed_up
from slipscale.experiments.dataset.hand_exclusions import decide
from slipscale.experiments.dataset.withdrawal import sources_with, withdraw
from slipscale.experiments.journal.locks import is_being_written
from slipscale.experiments.lab.console.actions.desk import Actions, Desk
from slipscale.experiments.lab.console.actions.forms import Form, Label, Nothing, Words
from slipscale.experiments.lab.console.state import Snapshot, ended_runs, export_folder
from slipscale.experiments.lab.unblinding import unblind
from slipscale.experiments.session.mailbox import LiveRequest, post
from slipscale.faults import UserError
from slipscale.faults.message import Message

# The words that confirm unblinding, in the console's languages.
CONFIRMING = frozenset({"unblind", "voir"})


class Unblind(Form):
    """Unblind the study. The operator must type ``word`` to confirm; a click is not enough."""

    word: str


def check_meant(word: str) -> None:
    """Raise `UserError` unless ``word`` is a confirmation."""
    if word.strip().casefold() not in CONFIRMING:
        raise UserError(
            "expected the word {confirming}", confirming=" or ".join(sorted(CONFIRMING))
        )


def _unblind(desk: Desk, request: Unblind) -> str:
    found = desk.now()
    check_meant(request.word)
    if found.roster is None:
        raise UserError("there are no participants yet")
    unblind(found.defaults.data, found.roster)
    live = found.live
    if live and live.status and not live.pilot:
        words = "the operator asked the console to show results (unblinded)"
        post(live.visit.path, LiveRequest(token=live.status.token, what="note", reason=words))
    desk.now()
    return "recorded: results are shown from now on"


class Work(Form):
    """Start a job that processes the whole data set."""

    what: Literal["verify", "build", "export"]


class Analyse(Form):
    """Analyse the participants' data, or the rehearsals, which unblind nobody."""

    pilot: bool = False


class Exclude(Form):
    """Exclude a participant from the analysis, or include them again."""

    participant: Label
    excluded: bool
    reason: Words
    pilot: bool = False


class Withdraw(Form):
    """Remove a participant's data. ``word`` must repeat the participant's label to confirm."""

    participant: Label
    word: Words
    pilot: bool = False


def _exclude(desk: Desk, request: Exclude) -> str:
    found = desk.now()
    decide(
        found.defaults.out(pilot=request.pilot),
        request.participant,
        excluded=request.excluded,
        reason=request.reason,
        results_seen=found.seen,
    )
    back_up_exclusions(found.defaults.out(pilot=request.pilot), request.participant)
    desk.now()
    done = "excluded" if request.excluded else "included again"
    return Message(
        "participant {participant} is {done}; this applies from the next analysis",
        participant=request.participant,
        done=done,
    )


def _withdraw(desk: Desk, request: Withdraw) -> str:
    found = desk.free()
    if request.word.strip() != request.participant:
        raise UserError(
            "expected the participant's label, {participant}", participant=request.participant
        )
    dataset = found.defaults.out(pilot=request.pilot)
    removed, remaining = withdraw(dataset, request.participant)
    desk.now()
    left = "".join(
        Message(
            " {dataset} was merged from {source}, which may still contain the participant's "
            "data: withdraw the participant there too.",
            dataset=dataset,
            source=source,
        )
        for source in sources_with(dataset, request.participant)
    )
    left += "".join(
        Message(
            " {path} may still hold data from the participant: look at it, and remove what is "
            "theirs.",
            path=path,
        )
        for path in remaining
    )
    return Message(
        "participant {participant} has withdrawn: {count} files and folders were removed or "
        "rewritten, including the results of all participants. Remove any copies of the data "
        "that you made elsewhere.{left}",
        participant=request.participant,
        count=len(removed),
        left=left,
    )


def _analyse(desk: Desk, request: Analyse) -> str:
    found = desk.now()
    if request.pilot:
        dataset = str(found.defaults.out(pilot=True))
        about = "the analysis of the rehearsals"
        desk.jobs.start("rehearsals", about, "analyse", "--steps", dataset)
        return "analysing"
    if not found.seen:
        raise UserError(
            "results would unblind you: unblind first, or wait for all planned participants"
        )
    _start_analysis(desk, found)
    return "analysing"


def _start_analysis(desk: Desk, found: Snapshot) -> None:
    desk.analysed = ended_runs(found)
    desk.jobs.start("analysis", "the analysis", "analyse", "--steps", str(found.defaults.data))


def renew(desk: Desk) -> None:
    """Repeat the analysis if runs have ended since the last analysis and results may be seen.

    No analysis starts during a session, because it could delay the session's frames. A failed
    analysis is repeated only after another run has ended.
    """
    found = desk.state.now()
    job = desk.jobs.last("analysis")
    if not found.seen or found.live or (job and job.running):
        return
    ended = ended_runs(found)
    newest_ns = max((changed_ns for _, changed_ns in ended), default=0)
    # Analyses by other processes are detected by the modification time of the results.
    due = bool(desk.analysed) or newest_ns > (found.results_ns or 0)
    if ended and ended != desk.analysed and due:
        _start_analysis(desk, found)


def _work(desk: Desk, request: Work) -> str:
    found = desk.now()
    data = found.defaults.data
    if request.what == "export" and not found.seen:
        raise UserError(
            "the export contains results: unblind first, or wait for all planned participants"
        )
    if found.live and not found.live.pilot:
        raise UserError(
            "a session of participant {live_label} is running; end it first",
            live_label=found.live.label,
        )
    words = {
        "verify": ("data", "verify", str(data), "--json"),
        "build": ("data", "build", str(data), "--json"),
        "export": ("export", str(data), "--out", str(export_folder(data))),
    }
    desk.jobs.start(
        request.what, Message("data set: {what}", what=request.what), *words[request.what]
    )
    return Message("started: {what}", what=request.what)


def _backup(desk: Desk, _: Nothing) -> str:
    found = desk.now()
    data, folder = found.defaults.data, found.defaults.backup
    if folder is None:
        raise UserError("no backup folder is set; name one on the Settings page")
    missing = [journal for journal in not_backed_up(data, folder) if not is_being_written(journal)]
    for journal in missing:
        back_up(data, journal, folder)
    desk.now()
    return Message("copied {count} runs to {folder}", count=len(missing), folder=folder)


ACTIONS: Actions = {
    "unblind": (Unblind, _unblind),
    "exclude": (Exclude, _exclude),
    "withdraw": (Withdraw, _withdraw),
    "analyse": (Analyse, _analyse),
    "work": (Work, _work),
    "backup": (Nothing, _backup),
}
