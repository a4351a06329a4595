"""Regenerate the pictures of the tutorial pages: a participant's screen and a figure per study.

Usage: make pictures, or python tools/tutorial_pictures.py [--only STUDY ...] [--folder DIR]
Requires a display; with a virtual one: xvfb-run -s "-screen 0 1280x800x24" ...
"""

from __future__ import annotations

import argparse
import io
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from PIL import Image

from slipscale import figure_style
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reporting.files import draw
from slipscale.experiments.participants.psychopy_window.display import Display
from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
from slipscale.experiments.running.rehearsal import dry_run
from slipscale.experiments.steps.steps import Adjust, Ask
from slipscale.hardware.clock import SystemClock

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.experiments.steps.screens.scene import Scene


IMAGES = Path(__file__).resolve().parent.parent / "docs" / "images" / "tutorials"


class Tutorial(NamedTuple):
    """Pictures of a study on a page: a figure from its pilot and, optionally, a screen."""

    page: str
    figure: str
    participants: int
    screen: bool


TUTORIALS = {
    "difference_threshold": Tutorial("thresholds", "tracks_differencethreshold", 4, True),
    # The screen is the same as for the difference threshold.
    "detection_threshold": Tutorial("thresholds", "thresholds_detectionthreshold", 4, False),
    "constant_stimuli": Tutorial("thresholds", "thresholds_constantstimuli", 4, False),
    "paired_comparison": Tutorial("comparing-surfaces", "scale_pairs", 8, True),
    "matching": Tutorial("comparing-surfaces", "matching_matching", 6, True),
}
WIDTH, COLOURS = 900, 64
SCREEN = (1280, 800)


def picture_name(study: str, what: str) -> str:
    """Return the name of a picture; ``what`` is "screen" or "figure".

    >>> picture_name("paired_comparison", "screen")
    'paired-comparison-screen.png'
    """
    return f"{study.replace('_', '-')}-{what}.png"


def main_screen(study: str) -> Scene:
    """Return the screen of a study's first question or first adjustment."""
    plan = pilot_plans(study, participants=1, seed=None, language="en")[0]
    for step in dry_run(plan):
        if isinstance(step, Ask | Adjust) and step.trial:
            return screen_for(step, plan.texts()).scene(0.0)
    raise LookupError(f"{study}: no question")


def figure_of(study: str) -> Figure:
    """Simulate a study's pilot with the study's random seed, and return its figure."""
    wanted = TUTORIALS[study]
    with tempfile.TemporaryDirectory() as where:
        folder = Path(where) / "data"
        plans = pilot_plans(study, participants=wanted.participants, seed=None, language="en")
        run_pilot(folder, plans, tell=lambda _: None)
        return draw(analyse(folder))[wanted.figure]


def small(picture: Image.Image, path: Path) -> None:
    """Save a picture no wider than `WIDTH`, with few colours."""
    height = round(picture.height * min(WIDTH / picture.width, 1.0))
    fitted = picture.convert("RGB").resize(
        (min(WIDTH, picture.width), height), Image.Resampling.LANCZOS
    )
    fitted.quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def main() -> int:
    """Make the pictures; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--only", nargs="+", choices=TUTORIALS, default=list(TUTORIALS))
    parser.add_argument("--folder", type=Path, default=IMAGES)
    options = parser.parse_args()
    with Display(SystemClock(), full_screen=False, screen=0, size=SCREEN) as display:
        for study in (each for each in options.only if TUTORIALS[each].screen):
            path = options.folder / picture_name(study, "screen")
            display.draw(main_screen(study))
            display.save(path)
            display.flip()
            small(Image.open(path), path)
    for study in options.only:
        raw = io.BytesIO()
        figure = figure_of(study)
        figure_style.lay_out(figure)
        figure.savefig(raw, format="png", dpi=160)
        small(Image.open(raw), options.folder / picture_name(study, "figure"))
        print(study)
    return 0


if __name__ == "__main__":
    sys.exit(main())
