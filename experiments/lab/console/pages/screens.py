"""The page that shows every participant screen, by language and screen size."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

from slipscale.experiments.lab.console.jobs import Jobs
from slipscale.experiments.lab.console.pages.view import View, plan_of, titles_of
from slipscale.experiments.lab.console.state import findings
from slipscale.experiments.participants.psychopy_window.drawing import drawn
from slipscale.experiments.running.screen_check import Seen, every_screen, in_each_language
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError

SIZES = ("1280x1024", "1366x768", "1920x1080", "2560x1440", "3840x2160")
USUAL = "1920x1080"
SIZE = re.compile(r"([0-9]{3,4})x([0-9]{3,4})")


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A screen on the page: its title, an SVG drawing, and the reasons why it is not readable."""

    title: str
    svg: str
    faults: tuple[str, ...]


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
    width_px, height_px = _pixels(size)
    return shown | {
        "language": language,
        "languages": [(name, sum(bool(s.faults) for s in all_)) for name, all_ in seen.items()],
        "pictures": [
            Picture(
                title=(title := _title(view, titles, screen)),
                svg=drawn(
                    screen.scene,
                    width_px=width_px,
                    height_px=height_px,
                    name=t("screens.picture", number=number, title=title),
                ),
                faults=screen.faults,
            )
            for number, screen in enumerate(seen[language], start=1)
        ],
    }


@lru_cache(maxsize=32)
def _all_of(plan: RunPlan) -> tuple[Seen, ...]:
    return tuple(every_screen(plan))


def _title(view: View, titles: dict[str, str], screen: Seen) -> str:
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
