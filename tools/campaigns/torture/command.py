"""Kill processes and inject disk faults, after which no answer may be lost or changed.

Usage: ``make torture`` (some minutes), ``make torture ARGS="--places 45 --write"`` (10,000 cases).

A pilot of each study is run uninterrupted. It is then repeated, interrupted at a different point
each time, and resumed until it is complete. The resulting data set is compared with the
uninterrupted one by file and row:

- `disk_faults`: a faulty file layer below the journal, at individual records;
- `system_calls`: real processes and SIGKILL, at four times as many system calls;
- `writers`: processes that open the same journal at once;
- `upkeep`: SIGKILL during ``build``, ``withdraw``, ``merge`` and ``--backup``.

Prints one row per fault; after Ctrl-C, it prints the results so far. The exit status is 1 if a data
set differs.
"""

from __future__ import annotations

import sys
import time
from argparse import ArgumentParser, Namespace
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from tools.campaigns.torture.pilots import Outcome, disk_campaign, looked_up_once, plans_of, studies
from tools.campaigns.torture.system_calls import CALLS, strike_campaign
from tools.campaigns.torture.upkeep import strike_upkeep
from tools.campaigns.torture.writers import writer_campaign

ROUNDS = 10  # of writers, per place


def table(outcome: Outcome) -> list[str]:
    """Return a Markdown table with the counts of each fault across all studies."""
    cases = Counter[str]()
    for (fault, _), count in outcome.counts.items():
        cases[fault] += count
    bad = Counter(fault for fault, _ in outcome.bad)
    return [
        "| fault | cases | data lost, duplicated or changed |",
        "| --- | --- | --- |",
        *(f"| {fault} | {count:,} | {bad[fault]} |" for fault, count in cases.items()),
    ]


def results(outcome: Outcome, places: int) -> str:
    """Return the results of a campaign as text for the documentation page."""
    names = dict.fromkeys(study for _, study in outcome.counts)
    said = (
        f"--places {places}: {outcome.counts.total():,} cases, {len(outcome.bad)} with different "
        f"data. Studies: {', '.join(f'`{name}`' for name in names)}."
    )
    return "\n".join([said, "", *table(outcome)])


def campaign(names: Sequence[str], places: int, participants: int, outcome: Outcome) -> None:
    """Apply every fault to every study; results are kept after an interruption."""
    plans = [plan for name in names for plan in plans_of(name, participants)]
    with looked_up_once():
        writer_campaign(plans[0], ROUNDS * (places or 100), outcome)
        strike_upkeep(CALLS * places, outcome)
        for plan in plans:
            began_s = time.monotonic()
            disk_campaign(plan, places, outcome)
            strike_campaign(plan, places, outcome)
            who = f"{Path(plan.study_name).stem}, participant {plan.participant} {plan.session}"
            print(f"{who}: {time.monotonic() - began_s:.0f} s", file=sys.stderr, flush=True)


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the campaign."""
    parser.add_argument(
        "--places", type=int, default=4, metavar="N", help="points per run (default: 4; 0: all)"
    )
    parser.add_argument(
        "--participants", type=int, default=1, metavar="N", help="number per study (default: 1)"
    )
    parser.add_argument(
        "--study", action="append", metavar="STUDY", help="study to run (default: all)"
    )


def run(args: Namespace) -> tuple[int, str]:
    """Run the campaign; return 1 if any data set differs."""
    outcome = Outcome()
    with suppress(KeyboardInterrupt):
        campaign(args.study or studies(), args.places, args.participants, outcome)
    text = results(outcome, args.places)
    print(text)
    for _, sentence in outcome.bad:
        print(sentence, file=sys.stderr)
    return int(bool(outcome.bad)), text
