"""The scenes of the console: how each is prepared, its page, and the button to press."""

from __future__ import annotations

from collections.abc import Callable

from slipscale.faults.message import Message
from slipscale.hardware.errors import ConnectionLost
from tools.console_pages.stage import Stage


def nothing(_: Stage) -> None:
    """Change nothing."""


UNREACHABLE = "--backup /media/disk: no such folder; connect its disk, or create it"
NOTHING = "nothing"  # an address that does not exist
# A table from another program, and choices for it.
OUTCOMES = "participant,pressure,outcome\n" + "".join(
    f"s{who},{level},{'hit' if (7 * who + 3 * turn) % 17 < level + 2 else 'miss'}\n"
    for who in range(1, 7)
    for level in (2, 4, 6, 8, 12, 16)
    for turn in range(10)
)
CHOSEN = {
    "roles": {"participant": "participant", "pressure": "stimulus", "outcome": "answer"},
    "codes": {"hit": "yes", "miss": "no"},
    "unit": "Pa",
}
FAULTY = {"roles": {"participant": "participant", "outcome": "stimulus", "pressure": "response"}}
PAGES = ("live", "study", "planning", "data", "pilot", "bench", "settings", "screens")
# Preparation, page, and selector of the button to press, keyed by the screenshot's name.
SCENES: dict[str, tuple[Callable[[Stage], object], str, str]] = {
    "today-new": (lambda stage: stage.hide("slipscale.toml", "data", "pilots"), "", ""),
    **{f"{page}-new": (nothing, page, "") for page in PAGES},
    "today-empty": (lambda stage: stage.hide("data", "pilots"), "", ""),
    **{f"{page}-empty": (nothing, page, "") for page in PAGES},
    "today": (Stage.hide, "", ""),
    "bench": (nothing, "bench", ""),
    "planning": (nothing, "planning", ""),
    "today-asks": (nothing, "", "[data-do=begin]"),
    "live-nothing": (nothing, "live", ""),
    "keys": (nothing, "", "[data-open=keys]"),
    "study": (nothing, "study", ""),
    "person": (nothing, "person?label=08", ""),
    "person-pilot": (nothing, "person?label=01&pilot=001", ""),
    "person-asks": (nothing, "person?label=01", "[data-do=withdraw]"),
    "study-template": (nothing, "study?from=matching", ""),
    "screens": (nothing, "screens", ""),
    "screens-french": (nothing, "screens?screens=fr&size=1280x1024", ".screens a"),
    "screens-text": (nothing, "screens?key=session.welcome&en=Hello+%7Bname%7D", ""),
    "settings": (nothing, "settings", ""),
    "data-blind": (nothing, "data", ""),
    "pilot": (nothing, "pilot", ""),
    "pilot-report": (nothing, "pilot/001/report", ""),
    "live": (lambda stage: stage.tell(), "live", ""),
    "today-live": (nothing, "", ""),
    "live-void": (nothing, "live", "[data-key=v]"),
    "live-answer": (
        lambda stage: stage.tell(answering="How slippery is this surface?"),
        "live",
        "",
    ),
    "live-answer-asks": (nothing, "live", "[data-key=e]"),
    "live-paused": (lambda stage: stage.tell(state="paused", plate="lost"), "live", ""),
    "live-fault": (
        lambda stage: stage.tell(
            state="fault",
            plate="lost",
            faults=2,
            voided=1,
            message=str(ConnectionLost("mock plate: the connection was lost")),
        ),
        "live",
        "",
    ),
    "live-warned": (
        lambda stage: stage.tell(
            warnings=[Message("NO BACKUP of this run: {fault}", fault=UNREACHABLE)]
        ),
        "live",
        "",
    ),
    "live-unblinded": (lambda stage: stage.tell(unblinded=True, level="1.2 µm"), "live", ""),
    "data": (Stage.unblind, "data", ""),
    "data-report": (nothing, "data/report", ""),
    "table-none": (nothing, "table", ""),
    "table-asks": (lambda stage: stage.upload(OUTCOMES), "table", ""),
    "table-faulty": (lambda stage: stage.describe(FAULTY, "#choices .why"), "table", ""),
    "table-report": (lambda stage: stage.report(CHOSEN), "table", ""),
    "table-own-report": (nothing, "table/001/report", ""),
    "table-sheets": (lambda stage: stage.upload_workbook(OUTCOMES), "table", ""),
    "planning-computed": (Stage.plan, "planning", ""),
    "planning-frozen": (
        lambda stage: stage.do("freeze", "main a[download]", "planning"),
        "planning",
        "",
    ),
    "pilot-runs": (
        lambda stage: stage.do("pilot", "progress", "pilot", participants=40, seed=3),
        "pilot",
        "",
    ),
    "today-failed": (lambda stage: stage.do("begin", "#next .bad", "", participant="09"), "", ""),
    "today-checked": (lambda stage: stage.do("check", "#checklist .checks", ""), "", ""),
    "person-excluded": (
        lambda stage: stage.do(
            "exclude",
            ".tag.damaged",
            "person?label=02",
            participant="02",
            excluded=True,
            reason="fever",
        ),
        "person?label=02",
        "",
    ),
    "person-withdrew": (
        lambda stage: stage.do(
            "withdraw", ".tag.withdrew", "person?label=03", participant="03", word="03"
        ),
        "person?label=03",
        "",
    ),
    "settings-tested": (
        lambda stage: stage.do("test", ".checks", "settings", plate="mock"),
        "settings",
        "",
    ),
    "bench-faulty": (lambda stage: stage.use("serial:/dev/ttyACM0,plate=none.toml"), "bench", ""),
    "bench-presents": (lambda stage: stage.use("mock"), "bench", "[data-form=surface] button"),
    "bench-typed": (
        lambda stage: stage.calibrate("#reading-typed:not([readonly])", table="typed"),
        "bench",
        "",
    ),
    "bench-calibrated": (lambda stage: stage.calibrate("[data-do=adopt]"), "bench", ""),
    "bench-verdicts": (
        lambda stage: stage.do("conform", "#conformance li"),
        "bench",
        "",
    ),
    "today-odd": (Stage.damage, "", ""),
    "data-odd": (lambda stage: stage.do("work", "#work .bad", "data", what="verify"), "data", ""),
    "study-compared": (nothing, "study", ""),
    "study-faulty": (lambda stage: stage.edit("participants =", "people ="), "study", ""),
    "study-broken": (lambda stage: stage.edit("people =", "people = ["), "study", ""),
    "study-gone": (Stage.lose, "", ""),
    "settings-faulty": (Stage.spoil, "settings", ""),
    "nothing": (nothing, NOTHING, ""),
}
