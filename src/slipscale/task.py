"""Public names for packages that add an analysis.

Import these names from here: their modules may move. See docs/extending/plug-ins.md.
"""

from slipscale.analysis.reading.labelled_tasks import TaskTrials, read_main_trials
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Family, Inputs, Named, Sentence, Statistic
from slipscale.analysis.tasks.kind import Analysis, TaskAnalysis
from slipscale.analysis.tasks.outside.short_form import OwnInput, OwnResult, own_analysis
from slipscale.analysis.writing.html import ReportSection
from slipscale.faults import UserError
from slipscale.figure_style import styled
from slipscale.stimuli.quantity import Quantity

__all__ = [
    "Analysis",
    "Family",
    "Inputs",
    "Named",
    "NotComputed",
    "OwnInput",
    "OwnResult",
    "Quantity",
    "ReportSection",
    "Sentence",
    "Statistic",
    "TaskAnalysis",
    "TaskTrials",
    "UserError",
    "own_analysis",
    "read_main_trials",
    "styled",
]
