"""Show the screen for each step, pass keys to the screen, and time the answer."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from typing import ClassVar, Self

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.participants.base import Kind, StopRequested, Turn, Unfinished, Watch
from slipscale.experiments.participants.psychopy_window.display import Display
from slipscale.experiments.participants.psychopy_window.keyboard import Key, Keyboard
from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.participants.psychopy_window.waiting import Stopping
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.screens.entry import ENTER, ERASE
from slipscale.experiments.steps.screens.scene import Scene
from slipscale.experiments.steps.screens.screen import Screen
from slipscale.experiments.steps.steps import Adjust, ParticipantStep
from slipscale.hardware.clock import Clock

# Number of notches by which one touch of an on-screen arrow key adjusts the surface.
TURNS = {scene.UP: 1, scene.DOWN: -1}
RELEASE_PATIENCE_S = 0.5  # time allowed for releasing a key that was just pressed


class PsychoPyWindow:
    """A participant who reads text in a PsychoPy window and answers with keys or the mouse.

    Parameters
    ----------
    texts : Mapping
        The texts in the participant's language; the keys of the window's texts begin with
        ``window.``.
    clock : Clock
        The session's clock, for onsets and response times.
    pilot : bool
        Whether every screen shows a banner that marks the run as a pilot.
    full_screen : bool
        Whether the window fills the screen and hides the mouse.
    screen : int
        Monitor number: 0, 1, ...
    size : tuple of int
        Width and height in pixels, if the window does not fill the screen.
    precise_times : bool
        Whether to compute response times from the device's key timestamps, if available.

    Raises
    ------
    UserError
        If there is no display or no screen with this number when the context is entered.
    """

    kind: ClassVar[Kind] = "person"
    unfinished = Unfinished()
    cursor_mm: tuple[float, float] | None = None

    def __init__(
        self,
        *,
        texts: Texts,
        clock: Clock,
        pilot: bool,
        full_screen: bool = True,
        screen: int = 0,
        size: tuple[int, int] = (1280, 800),
        precise_times: bool = True,
        theme: scene.Theme = scene.DARK,
        progress_line: bool = False,
    ) -> None:
        self._texts = texts
        self._clock = clock
        self._banner = scene.pilot_banner(texts["window.pilot"]) if pilot else ()
        self._with_line = progress_line
        self._line: Scene = ()
        self._precise_times = precise_times
        self.display = Display(
            clock, full_screen=full_screen, screen=screen, size=size, theme=theme
        )
        self.finger = self.display.pointer
        self._shown: Scene = ()
        self._pointed = False
        self._keyboard: Keyboard
        self._open = ExitStack()

    def __enter__(self) -> Self:
        with ExitStack() as opening:
            opening.enter_context(self.display)
            self._keyboard = Keyboard(
                self.display.handle, self._clock, precise_times=self._precise_times
            )
            opening.callback(self._close_keyboard)
            self._open = opening.pop_all()
        return self

    def __exit__(self, *_error: object) -> None:
        self._open.close()

    def _close_keyboard(self) -> None:
        if not self.display.connection.lost:
            self._keyboard.close()

    def _poll(self) -> list[Key]:
        with self.display.connection.used():
            return self._keyboard.poll()

    @property
    def focused(self) -> bool:
        """Whether this window has the keyboard focus."""
        return self._keyboard.focused

    @property
    def stamps_keys(self) -> bool:
        """Whether the device timestamps the key presses, as requested by ``precise_times``."""
        return self._keyboard.stamps

    def perform(self, step: ParticipantStep, watch: Watch) -> Reply:
        """Carry out one step and return what the participant did.

        The onset is the time of the first frame. Time spent on the question whether to stop is
        excluded from the response time and from the time limit.

        Parameters
        ----------
        step : Instruct, Explore, Ask or Rest
            The step to show.
        watch : callable
            Function to call on every frame. If it raises an exception, the exception propagates,
            and the step can be performed again.

        Raises
        ------
        StopRequested
            If the participant pressed Escape and confirmed.
        """
        screen = screen_for(step, self._texts)
        if self._with_line:
            trial = step.trial
            self._line = scene.progress_line((trial.number - 1) / trial.total) if trial else ()
        begun, self.unfinished = self.unfinished, Unfinished()
        screen.offer(begun.entry)
        screen.rejected.extend(begun.rejected)
        try:
            return self._perform(screen, watch)
        except BaseException:
            self.unfinished = Unfinished(entry=screen.typed, rejected=tuple(screen.rejected))
            raise

    def adjust(
        self,
        step: Adjust,
        turn: Turn,
        watch: Watch,
        *,
        again: int = 0,  # noqa: ARG002 - the screen is always the same
    ) -> Reply:
        """Let the participant adjust the surface until they confirm it (see also `perform`)."""
        return self._perform(screen_for(step, self._texts), watch, turn)

    def _perform(self, screen: Screen, watch: Watch, turn: Turn | None = None) -> Reply:
        onset_s = self._show_first(screen, watch)
        away_s = 0.0

        def timed(outcome: Reply, elapsed_s: float | None, source: str) -> Reply:
            return replace(
                outcome,
                onset_s=onset_s,
                response_time_s=elapsed_s,
                time_source=source,
                rejected=tuple(screen.rejected),
            )

        while True:
            notches = 0
            for key in self._touched(self._poll()):
                elapsed_s = key.time_s - onset_s - away_s
                if key.kind == "escape":
                    away_s += self._ask_to_stop(watch)
                    self._pointed = screen.pointed
                    break
                notches += key.notches if key.kind == "turn" else 0
                if notches and turn and key.character:
                    turn(notches)  # wheel turns before the confirming key press count
                    notches = 0
                outcome = self._hand_over(key, screen, elapsed_s)
                if outcome:
                    return timed(outcome, elapsed_s, key.source)
            outcome = screen.expire(self._clock.now() - onset_s - away_s)
            if outcome:
                return timed(outcome, None, "window")
            if notches and turn:
                turn(notches)
            watch()
            if self.cursor_mm:
                screen.see(*self.cursor_mm)
            self._show(screen.scene(self._clock.now() - onset_s - away_s))

    def _hand_over(self, key: Key, screen: Screen, elapsed_s: float) -> Reply | None:
        if key.kind != "point" or elapsed_s < 0:
            return hand_over(key, screen, elapsed_s)
        x, y = self.display.place(key.x, key.y)
        return screen.point(x, y, elapsed_s, dragged=key.repeated)

    def hold(self, text: str, until: Callable[[], bool]) -> None:
        """Show ``text`` until ``until()`` returns True. Keys are ignored."""
        while not until():
            self._poll()
            self._show(scene.message(text))

    def _show_first(self, screen: Screen, watch: Watch) -> float:
        """Discard earlier input, show the first frame of a screen, and return the frame's time."""
        if screen.single_key:
            self._await_release(watch)
        self._pointed = screen.pointed
        watch()
        self._poll()
        return self._show(screen.scene(0.0))

    def _show(self, shown: Scene) -> float:
        """Show one frame, and return its time on the session's clock."""
        if not self.focused:
            shown = scene.message(self._texts["window.focus"])
        self._shown = shown
        touched = any(isinstance(item, scene.Area) for item in shown)
        self.display.show_pointer(needed=self._pointed or touched)
        self.display.draw((*shown, *self._line, *self._banner))
        return self.display.flip()

    def _touched(self, keys: list[Key]) -> Iterator[Key]:
        """Yield the inputs, replacing a touch or click on a drawn key by the key's characters."""
        for key in keys:
            place = self.display.place(key.x, key.y)
            pressed = scene.pressed_at(self._shown, *place) if key.kind == "point" else ""
            if not pressed:
                yield key
            elif key.repeated:
                continue  # the pointer was dragged
            elif pressed in TURNS:
                yield replace(key, kind="turn", notches=TURNS[pressed])
            else:
                yield from (replace(key, kind="character", character=each) for each in pressed)

    def _await_release(self, watch: Watch) -> None:
        """Wait until all keys are released. A held key would otherwise answer the next screen."""
        began_s = self._clock.now()
        while self._keyboard.held:
            watch()
            self._poll()
            patient = self._clock.now() - began_s < RELEASE_PATIENCE_S
            self._show(() if patient else scene.message(self._texts["window.release_keys"]))

    def _ask_to_stop(self, watch: Watch) -> float:
        """Ask whether to stop. If the answer is no, return the time that the question took in s.

        Raises
        ------
        StopRequested
            If the participant confirms the stop.
        """
        began_s = self._clock.now()
        screen = Stopping(self._texts)
        onset_s = self._show_first(screen, watch)
        while True:
            for key in self._touched(self._poll()):
                outcome = hand_over(key, screen, key.time_s - onset_s)
                if outcome and outcome.value:
                    raise StopRequested("the participant pressed Escape and confirmed")
                if outcome:
                    self._await_release(watch)
                    return self._clock.now() - began_s
            watch()
            self._show(screen.scene(self._clock.now() - onset_s))


def hand_over(key: Key, screen: Screen, elapsed_s: float) -> Reply | None:
    """Pass a key to a screen, unless it was pressed too early or is an automatic repeat."""
    if key.kind in ("escape", "point") or elapsed_s < 0:
        return None
    if key.kind in ("turn", "move"):
        (screen.turn if key.kind == "turn" else screen.move)(key.notches)
        return None
    if key.kind == "erase" or key.character == ERASE:
        outcome = screen.erase()
        return None if key.repeated else outcome
    if key.repeated and (screen.single_key or key.character == ENTER):
        return None
    return screen.press(key.character, elapsed_s)
