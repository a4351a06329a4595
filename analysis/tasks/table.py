"""List the kinds of task in report order.

To add a kind, add a folder and one line here.
"""

from __future__ import annotations

from slipscale.analysis.tasks.difference import declaration as difference
from slipscale.analysis.tasks.estimation import declaration as estimation
from slipscale.analysis.tasks.exponent_and_weber import declaration as exponent_and_weber
from slipscale.analysis.tasks.factors import declaration as factors
from slipscale.analysis.tasks.friction import declaration as friction
from slipscale.analysis.tasks.groups import declaration as groups
from slipscale.analysis.tasks.identification import declaration as identification
from slipscale.analysis.tasks.limits import declaration as limits
from slipscale.analysis.tasks.matching import declaration as matching
from slipscale.analysis.tasks.pointing import declaration as pointing
from slipscale.analysis.tasks.productions import declaration as productions
from slipscale.analysis.tasks.ratings import declaration as ratings
from slipscale.analysis.tasks.ratios import declaration as ratios
from slipscale.analysis.tasks.same_different import declaration as same_different
from slipscale.analysis.tasks.scales import declaration as scales
from slipscale.analysis.tasks.sessions import declaration as sessions
from slipscale.analysis.tasks.similarity import declaration as similarity
from slipscale.analysis.tasks.thresholds import declaration as thresholds

KINDS = (
    estimation.ANALYSIS,
    sessions.ANALYSIS,
    groups.ANALYSIS,
    factors.ANALYSIS,
    friction.ANALYSIS,
    difference.ANALYSIS,
    thresholds.ANALYSIS,
    exponent_and_weber.ANALYSIS,
    scales.ANALYSIS,
    matching.ANALYSIS,
    ratings.ANALYSIS,
    ratios.ANALYSIS,
    productions.ANALYSIS,
    similarity.ANALYSIS,
    same_different.ANALYSIS,
    limits.ANALYSIS,
    identification.ANALYSIS,
    pointing.ANALYSIS,
)
#: In the order of ``inference.json``; a statistic may use the results of earlier ones.
STATISTICS = tuple(statistic for kind in KINDS for statistic in kind.statistics)
#: Kinds whose tasks a study can label, in the order in which their tables are recognised.
TRIALS = tuple(kind.trials for kind in KINDS if kind.trials is not None)
