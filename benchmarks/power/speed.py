"""Power against R's loop of the same model and tests; growth is in ``growth.py``.

    python benchmarks/power/speed.py [--studies 400] [--rounds 3]

R's side is `tests/data/power_reference/power.R`: base R, Friedman's test and Wilcoxon's of six
pairs with Holm's correction, of the magnitude question with 12 participants and one rating. Both
take turns in one run, in processor time; R's start is left out by timing inside R.
"""

from __future__ import annotations

import argparse
import subprocess
import time
from pathlib import Path
from statistics import median

from slipscale.analysis.planning.power.design import design_of
from slipscale.analysis.planning.power.grid import Condition
from slipscale.analysis.planning.power.shard import Shard
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.study.file import read_study

SCRIPT = Path(__file__).parents[2] / "tests" / "data" / "power_reference" / "power.R"
# The model and the tests of the script, without its cases, and one timed loop of them.
LOOP = """
begun <- sum(proc.time()[1:2])
found <- replicate({studies}, {{
  y <- study(12, 1, 1, 0)$means
  pairs <- combn(4, 2)
  p <- p.adjust(apply(pairs, 2, function(ij) signed_rank(y[, ij[2]] - y[, ij[1]])), "holm")
  c(friedman.test(y)$p.value < 0.05, p < 0.05)
}})
cat((sum(proc.time()[1:2]) - begun) / {studies})
"""


def r_loop_s(studies: int) -> float:
    model = SCRIPT.read_text(encoding="utf-8").partition('cat("participants')[0]
    done = subprocess.run(
        ["Rscript", "-e", model + LOOP.format(studies=studies)],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return float(done.stdout)


def ours_s(studies: int) -> float:
    """Return processor time of one shard."""
    design = design_of(*read_study("biet2007"), Population(), 0.05)
    condition = Condition(participants=12)
    began = time.process_time()
    Shard(design=design, condition=condition, number=0, studies=studies, seed=1).compute()
    return time.process_time() - began


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=400)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    ours_s(10)  # imports and tables
    theirs, ours = [], []
    for _ in range(options.rounds):
        theirs.append(r_loop_s(options.studies))
        ours.append(ours_s(10 * options.studies) / (10 * options.studies))
    ratio = median(theirs) / median(ours)
    print(f"R {1e6 * median(theirs):.0f} µs a study, ours {1e6 * median(ours):.0f} µs: {ratio:.0f}")


if __name__ == "__main__":
    main()
