"""The PsychoPy window, which draws scenes on the selected screen and paces the frames.

PsychoPy is imported when the window opens, because the import takes seconds and reads
``sys.argv``, the display and the home directory.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, Self

from slipscale.experiments.participants.psychopy_window.connection import Connection
from slipscale.experiments.steps.screens.scene import (
    COLOURS,
    DARK,
    DESIGN_WIDTH,
    FONT,
    Area,
    Arrow,
    Box,
    Disc,
    Item,
    Scene,
    Text,
    Theme,
    unbroken,
)
from slipscale.faults import UserError
from slipscale.hardware.clock import Clock
from slipscale.hardware.contact.source import Touch
from slipscale.hardware.signals import raise_if_ended

SMALLEST = 0.6  # relative size of a text that must shrink to fit
# Minimum frame duration. Without vertical sync, a loop without pauses would use a whole CPU core.
FRAME_S = 0.010


@contextmanager
def bare_argv() -> Iterator[None]:
    """Temporarily remove the command-line arguments, which PsychoPy would parse on import."""
    whole = sys.argv
    sys.argv = whole[:1]
    try:
        yield
    finally:
        sys.argv = whole


def import_visual() -> Any:
    """Import and return ``psychopy.visual``.

    Raises
    ------
    UserError
        If the display or a system library for windows is missing, or PsychoPy's settings cannot be
        written.
    """
    # After a failed import, a second one would appear to succeed, so the display is checked first.
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        raise UserError(
            "no display: DISPLAY is not set. Log in at the machine's own screen, or use a virtual "
            "display: xvfb-run slipscale run ..."
        )
    # Child processes must not inherit PsychoPy's own package folder.
    os.environ.setdefault("PSYCHOPYNOPACKAGES", "1")
    try:
        with bare_argv():
            from psychopy import logging, visual
    except ImportError as error:
        raise UserError(
            "PsychoPy cannot be loaded: {error}. Run python3 tools/system_packages.py for the "
            "system libraries, and make setup for the Python packages",
            error=error,
        ) from None
    except OSError as error:
        raise UserError(
            "PsychoPy cannot write its settings: {error}. Set HOME to a writable folder",
            error=error,
        ) from None
    except Exception as error:
        if type(error).__name__ != "NoSuchDisplayException":
            raise
        raise UserError(
            "no display responds at DISPLAY={display}. Check that the X server is running and that "
            "this user may use it",
            display=os.environ.get("DISPLAY"),
        ) from None
    logging.console.setLevel(logging.CRITICAL)  # the operator uses the terminal
    return visual


def screens() -> list[str]:
    """Return the sizes of the available screens. The list index is the screen number."""
    import_visual()
    import pyglet

    return [f"{s.width} x {s.height}" for s in pyglet.canvas.get_display().get_screens()]


def check_screen(number: int) -> None:
    """Raise `UserError` if a screen does not exist; PsychoPy would silently use another screen."""
    available = screens()
    if not 0 <= number < len(available):
        known = ", ".join(f"{n} ({size})" for n, size in enumerate(available))
        raise UserError(
            "screen {number}: no such screen; expected one of {known}", number=number, known=known
        )


class Pointer:
    """Reads the pointer position in a window, from a mouse or a touch panel acting as a mouse."""

    unit: Literal["mm", "px"] = "px"

    def __init__(self) -> None:
        self._window: Any = None
        self._mouse: Any = None

    def appears(self, window: Any) -> None:
        """Attach the pointer to the open window."""
        from psychopy import event

        self._window = window
        self._mouse = event.Mouse(visible=window.mouseVisible, win=window)

    def at(self, time_s: float) -> Touch | None:  # noqa: ARG002 - only the current position is known
        """Return the position in px right of and above the centre, or None outside the window."""
        if self._mouse is None:
            return None
        x, y = (float(each) for each in self._mouse.getPos())
        width, height = self._window.size
        # Before its first movement, the pointer is reported in the lower left corner.
        inside = -width / 2 < x <= width / 2 and -height / 2 < y <= height / 2
        return Touch(x, y) if inside else None


class Display:
    """A PsychoPy window on which scenes are drawn.

    Parameters
    ----------
    clock : Clock
        The session clock, used to time the frames.
    full_screen : bool
        Whether the window is full-screen and hides the mouse.
    screen : int
        0, 1, ...
    size : tuple of int
        Width and height in pixels, if the window does not fill the screen.
    """

    def __init__(
        self,
        clock: Clock,
        *,
        full_screen: bool,
        screen: int,
        size: tuple[int, int],
        theme: Theme = DARK,
    ) -> None:
        self._colours = COLOURS[theme]
        self._clock = clock
        self._full_screen = full_screen
        self._screen = screen
        self._size = size
        self._window: Any = None
        self._shown: dict[Item, Any] = {}
        self._frame_s = -FRAME_S
        self.pointer = Pointer()
        self.connection = Connection()

    def __enter__(self) -> Self:
        visual = import_visual()
        self.connection.guard()
        check_screen(self._screen)
        self._visual = visual
        with self.connection.used():
            self._open()
        return self

    def _open(self) -> None:
        visual = self._visual
        self._window = visual.Window(
            size=self._size,
            fullscr=self._full_screen,
            screen=self._screen,
            allowGUI=not self._full_screen,
            title="Slipscale",
            units="pix",
            color=self._colours["ground"],
            colorSpace="rgb255",
            checkTiming=False,  # PsychoPy's measurement of the frame rate takes 0.6 s
            autoLog=False,
            gammaErrorPolicy="ignore",
        )
        raise_if_ended()  # PsychoPy swallows exceptions while its window opens
        self.connection.watch(self._window.winHandle)
        self._window.mouseVisible = not self._full_screen
        self.pointer.appears(self._window)
        self._load_fonts()

    def __exit__(self, *_error: object) -> None:
        if not self.connection.lost:
            self._shown.clear()
            self._window.close()

    @property
    def handle(self) -> Any:
        """The pyglet window, which receives the keys."""
        return self._window.winHandle

    def show_pointer(self, *, needed: bool) -> None:
        """Show the mouse pointer, or hide it if the window is full-screen and does not need it."""
        visible = needed or not self._full_screen
        if visible != self._window.mouseVisible:
            self._window.mouseVisible = visible

    def place(self, x_px: float, y_px: float) -> tuple[float, float]:
        """Convert pixels, measured from the window's lower left corner, to scene coordinates."""
        width, height = self._window.size
        return (x_px - width / 2) / self._unit, (y_px - height / 2) / self._unit

    def draw(self, scene: Scene) -> None:
        """Draw a scene, which becomes visible at the next `flip`. Unchanged items are reused."""
        with self.connection.used():
            self._shown = {item: self._shown.get(item) or self._build(item) for item in scene}
            for item in scene:
                for stimulus in self._shown[item]:
                    stimulus.draw()

    def flip(self) -> float:
        """Show the drawn scene; return the session time at which it appeared."""
        with self.connection.used():
            self._window.flip()
        shown_s = self._clock.now()
        self._clock.sleep(FRAME_S - (shown_s - self._frame_s))
        self._frame_s = self._clock.now()
        return shown_s

    def save(self, path: Path) -> None:
        """Save the drawn scene to an image file before it becomes visible."""
        self._window.getMovieFrame(buffer="back")
        self._window.saveMovieFrames(str(path))

    def _load_fonts(self) -> None:
        import pyglet
        from psychopy import prefs

        for name in ("NotoSans-Regular.ttf", "NotoSans-Bold.ttf"):
            with Path(prefs.paths["assets"], "fonts", name).open("rb") as file:
                pyglet.font.add_file(file)

    @property
    def _unit(self) -> float:
        """Number of pixels per scene unit."""
        width, height = self._window.size
        return float(min(height, width / DESIGN_WIDTH))

    def _build(self, item: Item) -> tuple[Any, ...]:
        if isinstance(item, Area):
            return ()
        if isinstance(item, Arrow):
            return self._build_arrow(item)
        if isinstance(item, Disc):
            return self._build_disc(item)
        return self._build_box(item) if isinstance(item, Box) else self._build_text(item)

    def _build_disc(self, disc: Disc) -> tuple[Any, ...]:
        return (
            self._visual.Circle(
                self._window,
                radius=disc.diameter / 2 * self._unit,
                edges=64,  # PsychoPy derives its default from the line width, which is 0
                pos=(disc.x * self._unit, disc.y * self._unit),
                fillColor=self._colours[disc.colour],
                lineWidth=0,
                colorSpace="rgb255",
                autoLog=False,
            ),
        )

    def _build_arrow(self, arrow: Arrow) -> tuple[Any, ...]:
        half = arrow.size / 2 * self._unit
        tip = half if arrow.up else -half
        stem, head = 0.24 * half, 0.8 * half
        right = [(stem, -tip), (stem, 0), (head, 0)]
        outline = [*right, (0, tip), *((-x, y) for x, y in reversed(right))]
        return (
            self._visual.ShapeStim(
                self._window,
                vertices=outline,
                pos=(arrow.x * self._unit, arrow.y * self._unit),
                fillColor=self._colours[arrow.colour],
                lineWidth=0,
                colorSpace="rgb255",
                autoLog=False,
            ),
        )

    def _build_box(self, box: Box) -> tuple[Any, ...]:
        unit = self._unit
        return (
            self._visual.Rect(
                self._window,
                width=box.width * unit,
                height=box.height * unit,
                pos=(box.x * unit, box.y * unit),
                fillColor=self._colours[box.colour],
                lineWidth=0,
                colorSpace="rgb255",
                autoLog=False,
            ),
        )

    def _build_text(self, text: Text) -> tuple[Any, ...]:
        letters = self._fit(text) if text.content else None  # PsychoPy cannot draw empty text
        if not text.caret:
            return (letters,) if letters else ()
        width = letters.boundingBox[0] / self._unit if letters else 0
        caret = Box(
            x=text.x + width / 2 + 0.012, y=text.y, width=0.006, height=text.size, colour="accent"
        )
        return (*((letters,) if letters else ()), *self._build_box(caret))

    def _fit(self, text: Text) -> Any:
        """Return the drawn text, reduced in size if it would exceed the given height."""
        size = text.size
        letters = self._letters(text, size)
        limit = float("inf") if text.height is None else text.height * self._unit
        while letters.boundingBox[1] > limit and size > SMALLEST * text.size:
            size *= 0.94
            letters = self._letters(text, size)
        return letters

    def _letters(self, text: Text, size: float) -> Any:
        unit = self._unit
        left = text.align == "left"
        # PsychoPy draws capitals and digits below the middle of the line, so they are moved up to
        # the centre of the key.
        lift = 0.08 * size if text.anchor == "center" else 0.0
        return self._visual.TextStim(
            self._window,
            text=unbroken(text.content),
            font=FONT,
            bold=text.bold,
            height=size * unit,
            pos=((text.x - (text.width / 2 if left else 0)) * unit, (text.y + lift) * unit),
            anchorHoriz="left" if left else "center",
            anchorVert=text.anchor,
            alignText=text.align,
            wrapWidth=text.width * unit,
            color=self._colours[text.colour],
            colorSpace="rgb255",
            autoLog=False,
        )
