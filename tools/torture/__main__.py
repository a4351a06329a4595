"""The campaign of kills and faults: whatever happens, no answer is lost or changed.

Use: ``make torture`` (some minutes), ``make torture ARGS="--every 1 --write"`` (an hour or so).

A pilot of each study is run undisturbed. Then it is run again and again, each time disturbed at
another place; it is resumed as often as it takes, and the data set that comes out is compared with
the undisturbed one, file by file and row by row:

- `tools.torture.disk_faults`: a file layer below the journal, at each so many-th record;
- `tools.torture.system_calls`: real processes and SIGKILL, at each so many-th system call;
- `tools.torture.writers`: processes that open one journal at once.

Prints a row for each fault. Exit status 1 where one set of data differs.
"""

from __future__ import annotations

import argparse
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from tools.torture.pilots import Outcome, disk_campaign, looked_up_once, studies
from tools.torture.system_calls import kill_campaign
from tools.torture.writers import writer_campaign

if TYPE_CHECKING:
    from collections.abc import Sequence

PAGE = Path(__file__).parents[2] / "docs" / "reliability.md"
BEGIN, END = "<!-- figures: make torture -->\n", "<!-- end of figures -->\n"
ROUNDS = 1000  # of writers, at every 1


def table(outcomes: Sequence[Outcome]) -> list[str]:
    """Return the figures as lines of a table: a row for each fault, a column for each study."""
    counts = {key: count for outcome in outcomes for key, count in outcome.counts.items()}
    names = list(dict.fromkeys(study for _, study in counts))
    faults = list(dict.fromkeys(fault for fault, _ in counts))
    bad = [fault for outcome in outcomes for fault, _ in outcome.bad]
    heads = ["fault", *(f"`{name}`" for name in names), "data lost, doubled or changed"]
    lines = [f"| {' | '.join(heads)} |", f"|{' --- |' * len(heads)}"]
    for fault in faults:
        row = [counts.get((fault, name), 0) for name in names]
        cells = [fault, *(f"{count:,}" if count else "" for count in row), bad.count(fault)]
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return lines


def figures(outcomes: Sequence[Outcome], every: int, participants: int) -> str:
    """Return what the page says of a campaign."""
    cases = sum(sum(outcome.counts.values()) for outcome in outcomes)
    bad = sum(len(outcome.bad) for outcome in outcomes)
    people = "one participant" if participants == 1 else f"{participants} participants"
    where = "every record and call" if every == 1 else f"each {every}th record and call"
    said = (
        f"Last figures ({datetime.now(UTC).date()}; {people} of each study, {where}): "
        f"{cases:,} cases, {bad} with other data."
    )
    return "\n".join([said, "", *table(outcomes), ""])


def write(text: str) -> None:
    """Put the figures into the page."""
    page = PAGE.read_text(encoding="utf-8")
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    PAGE.write_text(f"{before}{BEGIN}{text}{END}{after}", encoding="utf-8")


def main(words: list[str] | None = None) -> int:
    """Run the campaign; return 1 where any data differed."""
    parser = argparse.ArgumentParser(prog="torture", description="kills and disk faults")
    parser.add_argument(
        "--every", type=int, default=14, metavar="N", help="disturb at each N-th (default: 14)"
    )
    parser.add_argument(
        "--participants", type=int, default=1, metavar="N", help="of each study (default: 1)"
    )
    parser.add_argument(
        "--study", action="append", metavar="STUDY", help="this one (default: all, and one more)"
    )
    parser.add_argument("--write", action="store_true", help="put the figures into the page")
    args = parser.parse_args(words)
    names = args.study or studies()
    began_s = time.monotonic()
    with looked_up_once():
        outcomes = [
            disk_campaign(names, args.every, args.participants),
            kill_campaign(names, args.every, args.participants),
            writer_campaign(names[0], max(ROUNDS // args.every, 1)),
        ]
    text = figures(outcomes, args.every, args.participants)
    print(text)
    for _, sentence in (line for outcome in outcomes for line in outcome.bad):
        print(sentence, file=sys.stderr)
    print(f"{time.monotonic() - began_s:.0f} s", file=sys.stderr)
    if args.write:
        write(text)
    return 1 if any(outcome.bad for outcome in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
