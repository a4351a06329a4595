"""Elements shared by screens: the prompt, the continue key and the countdown."""

from __future__ import annotations

import math

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.screens.scene import Scene, Text

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


def by_touch(texts: Texts) -> bool:
    """Return whether the participant answers with on-screen keys."""
    return texts["window.touch"] == "yes"


def going_on(texts: Texts, text: str) -> Scene:
    """Return a hint on how to continue, or a touch key to continue, for the bottom of a screen."""
    if not by_touch(texts):
        return (scene.hint(naming_key(texts, text)),)
    label = texts["window.go_on"]
    return scene.button(label, go_on_key(texts), x=0, y=-0.4, width=0.5, height=0.1)


def yes_no_keys(texts: Texts, yes: str, no: str, *, y: float) -> Scene:
    """Return the keys for yes and no, with the texts of two keys as their labels."""
    keys = (texts["window.yes_key"], texts["window.no_key"])
    return scene.key_row(keys, (texts[yes], texts[no]), y=y, touch=by_touch(texts))


def asked(prompt: str, *, y: float = 0.28) -> Text:
    """Return a question in large letters."""
    return Text(content=prompt.strip(), y=y, size=0.06, width=1.2, height=0.17)


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
