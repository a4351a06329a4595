"""Public names for packages that add a protocol or simulated people.

Import these names from here: their modules may move. See docs/extending/adding-a-protocol.md.
"""

from slipscale.experiments.participants.simulated_people.own_behaviour import Behaviour
from slipscale.experiments.protocol_parts.base import (
    Amplitude,
    AtLeastOne,
    Context,
    Count,
    Label,
    Options,
    Positive,
    Protocol,
    Seconds,
    Switch,
    Words,
)
from slipscale.experiments.protocol_parts.building_blocks.pacing import PacedOptions, RestedOptions
from slipscale.experiments.protocol_parts.building_blocks.repeating import Repeating, part_over
from slipscale.experiments.protocol_parts.simulated_answers import (
    SimulatedAnswer,
    as_asked,
    notices_difference,
    until_equal,
    until_number,
)
from slipscale.experiments.steps.columns import Column, IntervalRecord, TrialRecord, truth
from slipscale.experiments.steps.questions.base import Question
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.questions.comparison import ComparisonQuestion
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.questions.pointing import PointingQuestion, Selection
from slipscale.experiments.steps.questions.text import TextQuestion
from slipscale.experiments.steps.questions.visual_analogue import VisualAnalogueQuestion
from slipscale.experiments.steps.questions.whole_number import WholeNumberQuestion
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.replies import Adjusted, Answer, Presented, Reply, Voided
from slipscale.experiments.steps.rounding import rounded
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.steps import (
    Adjust,
    Ask,
    EndBlock,
    EndTrial,
    Explore,
    Feedback,
    Instruct,
    Present,
    Rest,
    Silence,
    Step,
    Steps,
)
from slipscale.experiments.steps.trial import Trial, Value
from slipscale.faults import UserError
from slipscale.faults.frozen_table import setting
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity
from slipscale.stimuli.surface import VirtualSurface

__all__ = [
    "PLATE_AMPLITUDE",
    "Adjust",
    "Adjusted",
    "Amplitude",
    "Answer",
    "Ask",
    "AtLeastOne",
    "Behaviour",
    "ChoiceQuestion",
    "Column",
    "ComparisonQuestion",
    "Context",
    "Count",
    "EndBlock",
    "EndTrial",
    "Explore",
    "Feedback",
    "Instruct",
    "IntervalRecord",
    "Label",
    "NumberQuestion",
    "Options",
    "PacedOptions",
    "PointingQuestion",
    "Positive",
    "Present",
    "Presented",
    "Protocol",
    "Quantity",
    "Question",
    "Repeating",
    "Reply",
    "Rest",
    "RestedOptions",
    "Seconds",
    "Selection",
    "Silence",
    "SimulatedAnswer",
    "SimulatedPerson",
    "Step",
    "Steps",
    "Switch",
    "TextQuestion",
    "Trial",
    "TrialRecord",
    "UserError",
    "Value",
    "VirtualSurface",
    "VisualAnalogueQuestion",
    "Voided",
    "WholeNumberQuestion",
    "Words",
    "YesNoQuestion",
    "as_asked",
    "notices_difference",
    "part_over",
    "rounded",
    "setting",
    "truth",
    "until_equal",
    "until_number",
]
