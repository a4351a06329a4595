"""Elements shared by screens: the continue key and the countdown."""

from __future__ import annotations

import math
from collections.abc import Mapping

from slipscale.experiments.participants.psychopy_window import scene
from slipscale.experiments.participants.psychopy_window.scene import Scene, Text

Texts = Mapping[str, str]

# Keys with a translated name; any other key is named by its character.
NAMED_KEYS = {"space": " ", "enter": "\r"}


def go_on_key(texts: Texts) -> str:
    """Return the lower-case character of the continue key."""
    key = texts["window.go_on_key"]
    return NAMED_KEYS.get(key, key).casefold()


def naming_key(texts: Texts, text: str) -> str:
    """Return a text with the name of the continue key inserted."""
    key = texts["window.go_on_key"]
    name = texts[f"window.key_{key}"] if key in NAMED_KEYS else key.upper()
    return texts[text].format(key=name)


def remaining(limit_s: float | None, elapsed_s: float, texts: Texts, *, y: float) -> Scene:
    """Return the countdown, which is empty if there is no time limit."""
    if limit_s is None:
        return ()
    left_s = max(limit_s - elapsed_s, 0.0)
    message = texts["window.seconds_left"].format(seconds=math.ceil(left_s))
    return (
        *scene.bar(left_s / limit_s if limit_s else 0.0, y=y),
        Text(content=message, y=y - 0.05, size=scene.HINT, colour="quiet"),
    )
