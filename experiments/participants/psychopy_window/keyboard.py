"""Combine the characters received by the window with the press times from the device.

The window handles the keyboard layout, but receives keys only when it is polled, once per frame.
Psychtoolbox timestamps each press in a separate thread, but reports only key positions (on a French
keyboard it confuses A and Q). The window and Psychtoolbox report the same presses in the same
order, so `claim` can assign a timestamp to each character.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal

from slipscale.hardware.clock import Clock

Kind = Literal["character", "erase", "escape", "turn", "move", "point"]
Source = Literal["ptb", "window"]
# A press stamped up to this time before the previous poll may reach the window only now.
LATE_S = 0.050
# The thread that timestamps key presses may lag this far behind the window.
EARLY_S = 0.004
# A held key starts repeating within this time (X11: 0.66 s, Windows: at most 1 s).
REPEAT_S = 1.1
PAGE_NOTCHES = 5  # notches of the wheel, for Page Up and Page Down
TO_THE_END = 1_000_000  # notches, for Home and End; longer than any line or list


@dataclass(frozen=True, slots=True)
class Key:
    """One input from the keyboard, the mouse or the touch screen.

    ``repeated`` marks inputs that come from holding a key or dragging the mouse. ``notches`` is the
    number of notches of a "turn" (up or down) or a "move" (right or left). ``x`` and ``y`` are the
    coordinates of a point in pixels, measured from the window's lower left corner.
    """

    kind: Kind
    character: str
    time_s: float
    source: Source = "window"
    repeated: bool = False
    notches: int = 0
    x: float = 0.0
    y: float = 0.0


def claim(heard: int, stamps_s: Iterable[float], last_poll_s: float, poll_s: float) -> list[float]:
    """Return the timestamps of the presses that the window received in one poll, in order.

    Parameters
    ----------
    heard : int
        Number of presses received by the window.
    stamps_s : iterable of float
        Unassigned timestamps in ascending order, in s on the session's clock.
    last_poll_s, poll_s : float
        Times of the previous and the current poll.

    Returns
    -------
    list of float
        One timestamp per press. If there are too few timestamps, the list is empty, because the
        times recorded by the window are preferable to wrong timestamps.

    Examples
    --------
    >>> claim(2, [0.1, 1.003, 1.009], last_poll_s=1.0, poll_s=1.016)
    [1.003, 1.009]
    >>> claim(2, [1.003], last_poll_s=1.0, poll_s=1.016)
    []
    """
    recent = [s for s in stamps_s if last_poll_s - LATE_S <= s <= poll_s + EARLY_S]
    return recent[:heard] if heard and len(recent) >= heard else []


class Stamps:
    """Key press times from Psychtoolbox, converted to the session clock."""

    def __init__(self, clock: Clock) -> None:
        # PsychoPy's Keyboard class is not used, because it reports a press only when the key is
        # released.
        from psychtoolbox import GetSecs, hid

        self._clock = clock
        self._get_secs = GetSecs
        devices = [-1] if sys.platform == "win32" else hid.get_keyboard_indices()[0]
        self._keyboards = [hid.Keyboard(device) for device in devices]
        for keyboard in self._keyboards:
            keyboard.queue_start()

    def read(self) -> list[float]:
        """Return the press times since the last call in ascending order, in s (session clock)."""
        presses = []
        for keyboard in self._keyboards:
            while keyboard.flush():
                event, _ = keyboard.queue_get_event()
                if event and event["Pressed"]:
                    presses.append(float(event["Time"]))
        if not presses:
            return []
        offset_s = self._offset_s()
        return sorted(time_s + offset_s for time_s in presses)

    def close(self) -> None:
        """Stop listening."""
        for keyboard in self._keyboards:
            keyboard.queue_stop()

    def _offset_s(self) -> float:
        """Return the offset between the clocks, from the most precise of five readings."""
        readings: list[tuple[float, float]] = []
        for _ in range(5):
            before_s = self._clock.now()
            theirs_s = float(self._get_secs())
            after_s = self._clock.now()
            readings.append((after_s - before_s, (before_s + after_s) / 2 - theirs_s))
        return min(readings)[1]


class Keyboard:
    """Keyboard input of one window.

    Parameters
    ----------
    handle : pyglet.window.Window
        The window.
    clock : Clock
        The session's clock.
    precise_times : bool
        Whether to use Psychtoolbox timestamps, if available.
    """

    def __init__(self, handle: Any, clock: Clock, *, precise_times: bool) -> None:
        import pyglet
        from pyglet.window import key

        self._pyglet = pyglet
        self._handle = handle
        self._clock = clock
        self._escape, self._backspace = key.ESCAPE, key.MOTION_BACKSPACE
        self._turns = {
            key.MOTION_UP: 1,
            key.MOTION_DOWN: -1,
            key.MOTION_PREVIOUS_PAGE: PAGE_NOTCHES,
            key.MOTION_NEXT_PAGE: -PAGE_NOTCHES,
        }
        self._moves = {
            key.MOTION_RIGHT: 1,
            key.MOTION_LEFT: -1,
            key.MOTION_BEGINNING_OF_LINE: -TO_THE_END,
            key.MOTION_END_OF_LINE: TO_THE_END,
        }
        self._modifiers = {
            key.LSHIFT, key.RSHIFT, key.LCTRL, key.RCTRL, key.LALT, key.RALT, key.LMETA, key.RMETA,
            key.LCOMMAND, key.RCOMMAND, key.LOPTION, key.ROPTION, key.CAPSLOCK, key.NUMLOCK,
            key.SCROLLLOCK, key.MODESWITCH,
        }  # fmt: skip
        self._held: set[int] = set()
        self._sign_s = clock.now()  # time of the last key press or repetition
        self._fresh: int | None = None  # index of the press whose character is not yet known
        self._presses = 0  # number of key presses since the last poll
        self._typed: list[tuple[Key, int | None]] = []
        self._unclaimed: list[float] = []
        self._poll_s = clock.now()
        self._activated = True
        self._stamps = self._find_stamps() if precise_times else None
        if sys.platform.startswith("linux"):
            self._hear_keys_where_accents_are_composed()
        handle.push_handlers(
            on_text=self._on_text,
            on_text_motion=self._on_text_motion,
            on_key_press=self._on_key_press,
            on_key_release=self._on_key_release,
            on_activate=self._on_activate,
            on_deactivate=self._on_deactivate,
            on_mouse_press=self._on_mouse_press,
            on_mouse_drag=self._on_mouse_drag,
            on_mouse_scroll=self._on_mouse_scroll,
            on_close=self._on_close,
        )
        handle.activate()

    def close(self) -> None:
        """Stop listening."""
        self._handle.pop_handlers()
        if self._stamps:
            self._stamps.close()

    @property
    def held(self) -> bool:
        """Whether any key is held down, except modifier keys such as Shift."""
        if self._clock.now() - self._sign_s > REPEAT_S:
            self._held.clear()  # a release event can get lost, for example when the layout changes
        return bool(self._held)

    @property
    def stamps(self) -> bool:
        """Whether Psychtoolbox timestamps the presses."""
        return self._stamps is not None

    @property
    def focused(self) -> bool:
        """Whether this window has the keyboard focus."""
        if sys.platform in {"win32", "darwin"}:
            return self._activated
        # Query X11, because a window that never had the focus gets no event for losing it.
        xlib = self._pyglet.libs.x11.xlib
        window, revert = xlib.Window(), ctypes.c_int()
        xlib.XGetInputFocus(
            self._handle._x_display,  # noqa: SLF001  pyglet has no public query
            ctypes.byref(window),
            ctypes.byref(revert),
        )
        return bool(window.value == self._handle._window)  # noqa: SLF001  as above

    def poll(self) -> list[Key]:
        """Return the inputs since the last call, in order."""
        self._handle.dispatch_events()
        now_s = self._clock.now()
        stamps: list[float] = []
        if self._stamps:
            self._unclaimed += self._stamps.read()
            stamps = claim(self._presses, self._unclaimed, self._poll_s, now_s)
            if self._presses and not stamps:
                self._clock.sleep(EARLY_S)
                self._unclaimed += self._stamps.read()
                stamps = claim(self._presses, self._unclaimed, self._poll_s, now_s)
            newest_s = stamps[-1] if stamps else now_s - 1.0
            self._unclaimed = [s for s in self._unclaimed if s > newest_s]
        typed = [
            replace(key, time_s=stamps[press], source="ptb")
            if press is not None and stamps
            else key
            for key, press in self._typed
        ]
        self._typed, self._presses, self._fresh, self._poll_s = [], 0, None, now_s
        return typed

    def _hear_keys_where_accents_are_composed(self) -> None:
        """Make X11 send keys to the window itself instead of the child window for drawing.

        X11 sends keys to the innermost window under the pointer that listens for keys. Xlib
        composes accents (dead keys, Compose) only for the window of the input context, not for
        pyglet's child window, which would receive ^ e as e. This function stops the child window
        from listening, so that X11 passes the keys on to the outer window.
        """
        xlib, handle = self._pyglet.libs.x11.xlib, self._handle
        everything_else = handle._default_event_mask & ~(  # noqa: SLF001  pyglet offers no other way
            xlib.KeyPressMask | xlib.KeyReleaseMask
        )
        xlib.XSelectInput(handle._x_display, handle._view, everything_else)  # noqa: SLF001  as above

    def _find_stamps(self) -> Stamps | None:
        try:
            return Stamps(self._clock)
        except Exception:  # noqa: BLE001  it raises plain Exception without permission to listen
            return None  # response times then come from the window

    def _hear(self, kind: Kind, character: str = "", notches: int = 0) -> None:
        press, self._fresh = self._fresh, None
        self._sign_s = self._clock.now()
        repeated = press is None and self.held
        heard = Key(kind, character, self._clock.now(), repeated=repeated, notches=notches)
        self._typed.append((heard, press))

    # Event handlers of the window. Returning True prevents PsychoPy's handlers from buffering the
    # event.

    def _on_key_press(self, symbol: int, _modifiers: int) -> bool:
        self._fresh = self._presses
        self._presses += 1
        if symbol == self._escape:
            self._hear("escape")
        if symbol not in self._modifiers:
            self._held.add(symbol)
            self._sign_s = self._clock.now()
        return True

    def _on_key_release(self, symbol: int, _modifiers: int) -> bool:
        if symbol in self._held:
            self._held.discard(symbol)
        elif symbol not in self._modifiers:
            # If Shift is released before the key, the symbol of the release differs from the symbol
            # of the press, and pyglet would treat the key as held down forever.
            self._held.clear()
            getattr(self._handle, "pressed_keys", set()).clear()
        return True

    def _on_text(self, text: str) -> bool:
        for character in text:
            self._hear("character", character)
        return True

    def _on_text_motion(self, motion: int) -> bool:
        if motion == self._backspace:
            self._hear("erase")
        elif motion in self._turns:
            self._hear("turn", notches=self._turns[motion])
        elif motion in self._moves:
            self._hear("move", notches=self._moves[motion])
        return True

    def _on_activate(self) -> None:
        self._activated = True

    def _on_deactivate(self) -> None:
        self._activated = False
        self._held.clear()  # another window receives the release events

    def _on_mouse_press(self, x: int, y: int, *_which: int) -> bool:
        self._handle.activate()
        self._typed.append((Key("point", "", self._clock.now(), x=x, y=y), None))
        return True

    def _on_mouse_drag(self, x: int, y: int, *_how: int) -> bool:
        self._typed.append((Key("point", "", self._clock.now(), repeated=True, x=x, y=y), None))
        return True

    def _on_mouse_scroll(self, _x: int, _y: int, _across: float, notches: float) -> bool:
        if round(notches):
            self._typed.append((Key("turn", "", self._clock.now(), notches=round(notches)), None))
        return True

    def _on_close(self) -> bool:
        self._hear("escape")
        return True
