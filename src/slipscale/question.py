"""Public names for packages that add a kind of question.

Import these names from here: their modules may move. See docs/extending/adding-a-question.md.
"""

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.steps.columns import Column, TrialRecord
from slipscale.experiments.steps.questions.base import Question
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.screens.entry import (
    ENTER,
    Entry,
    KeyEntry,
    ListEntry,
    Refused,
    TypedEntry,
)
from slipscale.experiments.steps.screens.scene import (
    Area,
    Arrow,
    Box,
    Disc,
    Scene,
    Text,
    button,
    key_list,
    key_row,
)
from slipscale.experiments.steps.screens.screen import Screen
from slipscale.experiments.steps.screens.screen_texts import (
    asked,
    by_touch,
    go_on_key,
    naming_key,
    remaining,
)
from slipscale.experiments.steps.simulated_person import Draws, SimulatedPerson
from slipscale.experiments.steps.trial import Value

__all__ = [
    "ENTER",
    "Area",
    "Arrow",
    "Box",
    "Column",
    "Disc",
    "Draws",
    "Entry",
    "KeyEntry",
    "ListEntry",
    "Question",
    "Refused",
    "Reply",
    "Scene",
    "Screen",
    "SimulatedPerson",
    "Text",
    "Texts",
    "TrialRecord",
    "TypedEntry",
    "Value",
    "asked",
    "button",
    "by_touch",
    "go_on_key",
    "key_list",
    "key_row",
    "naming_key",
    "remaining",
]
