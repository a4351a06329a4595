"""Compare the main results with and without flagged participants."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from slipscale.analysis.preprocessing.log_transform import Prepared, prepare
from slipscale.analysis.statistics.not_computed import NotComputed, computed
from slipscale.analysis.statistics.power_law import PowerLaw, power_law
from slipscale.analysis.statistics.repeated_measures.omnibus import Friedman, friedman
from slipscale.experiments.dataset.schema import PARTICIPANT


@dataclass(frozen=True, slots=True, kw_only=True)
class SubsetSummary:
    """The main results for all or some of the participants.

    Parameters
    ----------
    participants : str
        Description of the subset.
    n : int
        Number of participants.
    power_law, friedman
        The group exponent and the result of Friedman's test.
    means : Mapping
        Mean normalised estimates, keyed by amplitude in µm peak to peak.
    """

    participants: str
    n: int
    power_law: PowerLaw | NotComputed
    friedman: Friedman | NotComputed
    means: Mapping[float, float]

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        exponent, friedman = computed(self.power_law), computed(self.friedman)
        return {
            "participants": self.participants,
            "n": self.n,
            "exponent": exponent.exponent if exponent else None,
            "exponent_ci": exponent.interval if exponent else None,
            "friedman_chi2": friedman.chi2 if friedman else None,
            "friedman_p": friedman.p if friedman else None,
            "means": self.means,
        }


def robustness(everyone: Prepared, flagged: set[str]) -> tuple[SubsetSummary, ...]:
    """Return the main results for all participants and, if only some have flags, for the others."""
    kept = ~everyone.trials[PARTICIPANT].isin(flagged)
    sets = {"all analysed participants": everyone}
    if flagged and kept.any():
        trials = everyone.trials[kept].reset_index(drop=True)
        sets["without flagged participants"] = prepare(trials, everyone.choices, everyone.quantity)
    return tuple(
        SubsetSummary(
            participants=name,
            n=len(data.cells),
            power_law=power_law(data),
            friedman=friedman(data),
            means=dict(
                zip(
                    data.cells.columns.to_numpy(float).tolist(),
                    data.cells.mean().tolist(),
                    strict=True,
                )
            ),
        )
        for name, data in sets.items()
    )
