"""Are the orders of surfaces uniform? Chi-square tests over many participants, for every rule.

    python benchmarks/orders.py [--participants 20000]

For each rule: the first surface, the whole first block, the transition in the middle of the first
block, the transition from practice to the main trials, the transition across the first border of
blocks, and the first surfaces of a participant's two sessions together. Of a Williams design one
participant a group counts: the others of the group are not independent of them (that balances
them). The exit status is 1 where a p-value is below 0.01 after Bonferroni's correction.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from itertools import permutations, product
from math import factorial
from typing import TYPE_CHECKING

from scipy.stats import chisquare

from slipscale.experiments.protocols.base import Context
from slipscale.experiments.protocols.building_blocks.rated_surfaces import order_blocks
from slipscale.experiments.protocols.magnitude_estimation import MagnitudeEstimation
from slipscale.experiments.protocols.ordering.williams import williams_group, williams_square

if TYPE_CHECKING:
    from collections.abc import Iterator

# Rule, surfaces, repetitions, no_immediate_repeat.
SETTINGS = [
    (rule, surfaces, repetitions, alone)
    for rule in ("simple", "blocked", "williams")
    for surfaces, repetitions in ((4, 2), (4, 4), (5, 3))
    for alone in (True, False)
]
FALSE_ALARM = 0.01


def same_across_border(options: MagnitudeEstimation, surfaces: int) -> float:
    """Return the probability that a block begins with the surface that ended the one before."""
    if options.no_immediate_repeat:
        return 0.0
    if options.randomisation == "simple":  # no blocks: any two neighbours
        return (options.repetitions - 1) / (surfaces * options.repetitions - 1)
    if options.randomisation == "blocked":
        return 1 / surfaces
    square = williams_square(surfaces)
    clashes = sum(one[-1] == other[0] for one, other in permutations(square, 2))
    return clashes / (len(square) * (len(square) - 1))


def drawn(
    options: MagnitudeEstimation, surfaces: int, participants: int, seed: int
) -> Iterator[Counter[tuple[str, object]]]:
    """Yield what is counted of each participant: (test, outcome) pairs."""
    group = 1
    if options.randomisation == "williams":
        alone = options.no_immediate_repeat
        group = williams_group(surfaces, options.repetitions, no_immediate_repeat=alone)
    for number in range(participants):
        row = number * group + number % group
        first, second = (
            order_blocks(
                surfaces,
                options,
                Context(
                    seed=seed,
                    participant=f"{row + 1:02d}",
                    row=row,
                    amplitudes_um_pp=tuple(float(each) for each in range(surfaces)),
                    texts={},
                    visit=visit,
                    session=f"{visit + 1:02d}",
                ),
            )
            for visit in (0, 1)
        )
        practice = [each for phase, block in first if phase == "practice" for each in block]
        main = [each for phase, block in first if phase == "main" for each in block]
        again = next(block[0] for phase, block in second if phase == "main")
        yield Counter(
            [
                ("first surface", main[0]),
                ("first block", tuple(main[:surfaces])),
                ("inside a block", (main[1], main[2])),
                ("practice to main", (practice[-1], main[0])),
                ("across a border", (main[surfaces - 1], main[surfaces])),
                ("two sessions", (main[0], again)),
            ]
        )


def expected(test: str, options: MagnitudeEstimation, surfaces: int) -> dict[object, float] | None:
    """Return the probability of each outcome of a test; None where the rule does not give any."""
    simple = options.randomisation == "simple"
    everything = range(surfaces)

    def pairs(same: float) -> dict[object, float]:
        other = (1 - same) / (surfaces * (surfaces - 1))
        return {
            (one, two): same / surfaces if one == two else other
            for one, two in product(everything, repeat=2)
        }

    if test == "first surface":
        return dict.fromkeys(everything, 1 / surfaces)
    if test == "first block":
        # All orders shuffled together: the first few may be any.
        orders = permutations(everything)
        return None if simple else dict.fromkeys(orders, 1 / factorial(surfaces))
    if test == "inside a block":
        return pairs(same_across_border(options, surfaces) if simple else 0.0)
    if test == "practice to main":
        return pairs(0.0 if options.no_immediate_repeat else 1 / surfaces)
    if test == "across a border":
        return pairs(same_across_border(options, surfaces))
    # Visits that advance have different rows of one square: not independent, on purpose.
    return None if options.randomisation == "williams" else pairs(1 / surfaces)


def main() -> int:
    """Print a table of p-values."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--participants", type=int, default=20_000)
    participants = parser.parse_args().participants
    print(f"{participants} participants a row\n")
    print("rule      surfaces  repetitions  no repeat  test              cells  chi-square       p")
    least, tests = 1.0, 0
    for seed, (rule, surfaces, repetitions, alone) in enumerate(SETTINGS):
        options = MagnitudeEstimation(
            protocol="magnitude_estimation",
            randomisation=rule,
            repetitions=repetitions,
            no_immediate_repeat=alone,
        )
        seen = sum(drawn(options, surfaces, participants, seed), Counter())
        for test in dict.fromkeys(name for name, _ in seen):
            chances = expected(test, options, surfaces)
            if chances is None:
                continue
            possible = {outcome: chance for outcome, chance in chances.items() if chance}
            counts = [seen[test, outcome] for outcome in possible]
            beyond = participants - sum(counts)
            found = chisquare(counts, [participants * chance for chance in possible.values()])
            p = 0.0 if beyond else found.pvalue
            least, tests = min(least, p), tests + 1
            print(
                f"{rule:<9} {surfaces:>8}  {repetitions:>11}  {'yes' if alone else 'no':<9}  "
                f"{test:<16}  {len(counts):>5}  {found.statistic:>10.1f}  {p:>6.3f}",
                flush=True,
            )
    good = least * tests > FALSE_ALARM
    print(f"\n{tests} tests, least p = {least:.4f}, {'uniform' if good else 'NOT uniform'}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
