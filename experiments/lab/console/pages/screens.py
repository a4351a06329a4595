"""The page that shows every participant screen, by language and screen size."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from slipscale.experiments.lab.console.actions.forms import text_hash
from slipscale.experiments.lab.console.jobs import Jobs
from slipscale.experiments.lab.console.pages.own_text import edited_plan, own_text
from slipscale.experiments.lab.console.pages.view import View, plan_of, titles_of
from slipscale.experiments.lab.console.state import findings
from slipscale.experiments.participants.psychopy_window.drawing import drawn
from slipscale.experiments.running.screen_check import in_each_language
from slipscale.experiments.running.screen_keys import KeyedScreen, keyed_screens
from slipscale.experiments.study.file import study_text
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError

SIZES = ("1280x720", "1280x800", "1280x1024", "1366x768", "1920x1080", "2560x1440", "3840x2160")
USUAL = "1920x1080"
SIZE = re.compile(r"([0-9]{3,4})x([0-9]{3,4})")


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A screen on the page: its title, an SVG drawing, and the reasons why it is not readable.

    ``keys`` are the keys of the texts on the screen.
    """

    title: str
    svg: str
    faults: tuple[str, ...]
    keys: tuple[str, ...]


def screens(view: View) -> dict[str, object]:
    """Return the template values for the page that shows the participant's screens."""
    found, t = view.found, view.t
    checked = _size_of_the_check(view.jobs)
    wanted = view.query.get("size", "")
    size = wanted if SIZE.fullmatch(wanted) else checked or USUAL
    shown: dict[str, object] = {
        "language": "",
        "languages": [],
        "pictures": [],
        "size": size,
        "checked": checked,
        "sizes": sorted({*SIZES, size, *filter(None, [checked])}, key=_pixels),
        "fault": "",
        "own": None,
    }
    if found.study is None:
        return shown
    try:
        plans = {plan.language: plan for plan in in_each_language(plan_of(found, "01"))}
        seen = {language: _all_of(plan) for language, plan in plans.items()}
    except UserError as error:
        return shown | {"fault": str(error)}
    language = view.query.get("screens", "")
    language = language if language in plans else next(iter(plans))
    titles = titles_of(found, t)
    own = own_text(view, plans)
    listed: Sequence[KeyedScreen] = seen[language]
    if own is not None:
        listed = _showing(own.key, edited_plan(plans[language], own) if own.study_text else None)
    width_px, height_px = _pixels(size)
    return shown | {
        "language": language,
        "own": own,
        "before": text_hash(study_text(found.defaults.study)) if own else "",
        "languages": [(name, sum(bool(s.faults) for s in all_)) for name, all_ in seen.items()],
        "pictures": [
            Picture(
                title=(title := _title(view, titles, screen)),
                svg=drawn(
                    screen.scene,
                    width_px=width_px,
                    height_px=height_px,
                    name=t("screens.picture", number=number, title=title),
                    keys=screen.keys,
                    theme=plans[language].study.screens,
                ),
                faults=screen.faults,
                keys=tuple(dict.fromkeys(key for each in screen.keys for key in each)),
            )
            for number, screen in enumerate(listed, start=1)
        ],
    }


@lru_cache(maxsize=32)
def _all_of(plan: RunPlan) -> tuple[KeyedScreen, ...]:
    return tuple(keyed_screens(plan))


def _showing(key: str, plan: RunPlan | None) -> list[KeyedScreen]:
    """Return the screens of a plan that show a text; empty without a plan."""
    return [each for each in (_all_of(plan) if plan else ()) if any(key in at for at in each.keys)]


def _title(view: View, titles: dict[str, str], screen: KeyedScreen) -> str:
    kind = view.t.known(f"screens.{screen.step}", screen.step)
    return f"{titles[screen.task]}: {kind}" if screen.task in titles else kind


def _pixels(size: str) -> tuple[int, int]:
    width, _, height = size.partition("x")
    return int(width), int(height)


def _size_of_the_check(jobs: Jobs) -> str:
    """Return the screen size reported by the last checklist; empty if it is unknown."""
    check = jobs.last("check")
    for finding in findings(check.said()) or () if check else ():
        size = re.search(r"([0-9]{3,4}) x ([0-9]{3,4})", str(finding.get("detail", "")))
        if finding.get("name") == "display" and size:
            return f"{size[1]}x{size[2]}"
    return ""
