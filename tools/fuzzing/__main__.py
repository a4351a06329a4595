"""Run the fuzzing campaign: each input file must be used or rejected with an error message.

Usage: ``make fuzz`` (10,000 inputs of each kind), ``make fuzz TEXTS=100000 ARGS=--write``.

Each kind of input is a module of this package, which defines the inputs and how to use them. Each
process tries 1,000 inputs of one kind with limited processor time and memory. Processes alternate
between the kinds, so that an interrupted campaign covers all of them. A campaign continues from
``build/fuzz.json`` (``--anew`` restarts it). An input that fails is identified by its kind and
number:

    python -m tools.fuzzing --show journals 4711     # prints the input, and uses it

The exit status is 1 if an input was neither used nor rejected with an error message.
"""

from __future__ import annotations

import argparse
import json
import mmap
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path

from tools.fuzzing.campaign import KINDS, Find, Outcome, case, kind_of, tried
from tools.page_figures import put

STATE = Path(__file__).parents[2] / "build" / "fuzz.json"
# Number of inputs per process, whose memory leaks add up.
CHUNK = 1000
# Number of bytes in the counter that a process shares with its parent.
WIDTH = 8


def chunk(name: str, numbers: Sequence[int]) -> Outcome:
    """Try inputs in a separate process; an input that kills the process is also recorded."""
    with tempfile.NamedTemporaryFile() as place:
        place.write(bytes(WIDTH))
        place.flush()
        done = subprocess.run(
            [sys.executable, "-m", "tools.fuzzing", "--chunk", name, place.name],
            input=json.dumps(list(numbers)),
            capture_output=True,
            text=True,
            check=False,
        )
        count = int.from_bytes(Path(place.name).read_bytes())
    if done.returncode == 0:
        return outcome_from(json.loads(done.stdout))
    if done.returncode < 0 and count:
        what = f"ended the process with signal {-done.returncode}"
        find = Find(kind=name, number=numbers[count - 1], what=what)
        return Outcome(tried=count, finds=[find])
    raise RuntimeError(f"{name} from {numbers[0]}: {done.stderr[-2000:]}")


def child(name: str, place: Path) -> None:
    """Read the numbers of inputs from standard input, try the inputs, and print the outcome.

    The number of inputs started is written to the file at ``place``, which the parent reads.
    """
    numbers = json.load(sys.stdin)
    with place.open("r+b") as file, mmap.mmap(file.fileno(), WIDTH) as begun:

        def counted() -> Iterator[int]:
            for count, number in enumerate(numbers, 1):
                begun[:] = count.to_bytes(WIDTH)
                yield number

        outcome = tried(name, counted())
    print(json.dumps(asdict(outcome)))


def outcome_from(data: dict[str, object]) -> Outcome:
    """Create an outcome from parsed JSON."""
    finds = [Find(**each) for each in data.pop("finds")]  # type: ignore[attr-defined]
    return Outcome(**data, finds=finds)  # type: ignore[arg-type]


def read_state() -> dict[str, Outcome]:
    """Read the saved outcome of each kind."""
    if not STATE.exists():
        return {}
    known = json.loads(STATE.read_text(encoding="utf-8"))
    return {name: outcome_from(each) for name, each in known.items()}


def write_state(state: dict[str, Outcome]) -> None:
    """Save the outcome of each kind."""
    STATE.parent.mkdir(exist_ok=True)
    text = json.dumps({name: asdict(each) for name, each in state.items()}, indent=1)
    STATE.write_text(text, encoding="utf-8")


def campaign(names: Sequence[str], texts: int, processes: int, state: dict[str, Outcome]) -> None:
    """Try inputs until ``texts`` of each kind were tried, with at most one process per kind."""
    for name in names:
        known = state.setdefault(name, Outcome())
        if known.finds:  # possibly fixed since
            known.finds = chunk(name, [find.number for find in known.finds]).finds
    running: dict[Future[Outcome], str] = {}
    with ThreadPoolExecutor(processes) as pool:
        while True:
            idle = [n for n in names if n not in running.values() and state[n].tried < texts]
            idle.sort(key=lambda name: state[name].tried)
            for name in idle[: processes - len(running)]:
                first = state[name].tried
                numbers = range(first, min(first + CHUNK, texts))
                running[pool.submit(chunk, name, numbers)] = name
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                name, found = running.pop(future), future.result()
                add(state[name], found)
                write_state(state)
                print(_line(name, state[name]), file=sys.stderr, flush=True)


def add(whole: Outcome, part: Outcome) -> None:
    """Add ``part`` to ``whole``."""
    whole.tried += part.tried
    whole.used += part.used
    whole.longest_s = max(whole.longest_s, part.longest_s)
    whole.finds += part.finds


def table(state: dict[str, Outcome]) -> list[str]:
    """Return the lines of a Markdown table of the outcomes."""
    heads = ("inputs", "tried", "accepted", "longest CPU time, s", "failures")
    lines = [f"| {' | '.join(heads)} |", f"|{' --- |' * len(heads)}"]
    return [*lines, *(_line(name, outcome) for name, outcome in state.items())]


def _line(name: str, found: Outcome) -> str:
    return (
        f"| {kind_of(name).title} | {found.tried:,} | {found.used:,} | {found.longest_s:.2f} | "
        f"{len(found.finds)} |"
    )


def causes(state: dict[str, Outcome]) -> list[str]:
    """Return a sentence per cause: number of failures, first failure and how to reproduce it."""
    first: dict[tuple[str, str], list[Find]] = {}
    for outcome in state.values():
        for find in outcome.finds:
            first.setdefault((find.kind, find.what.partition(":")[0]), []).append(find)
    return [
        f"{len(finds)} × {finds[0].what}; python -m tools.fuzzing --show {name} {finds[0].number}"
        for (name, _), finds in first.items()
    ]


def show(name: str, number: int) -> None:
    """Print an input and use it, without catching exceptions."""
    with tempfile.TemporaryDirectory() as place:
        text = case(kind_of(name).prepared(Path(place)), name, number)
        print(f"{text.name}\n{text.content!r}")
        print("used" if text.use() else "rejected with an error message")


def main(words: list[str] | None = None) -> int:
    """Run the campaign; return 1 if an input failed."""
    parser = argparse.ArgumentParser(prog="fuzzing", description="Fuzz Slipscale's input files.")
    parser.add_argument("--texts", type=int, default=10_000, help="per kind (default: 10000)")
    parser.add_argument("--kind", action="append", choices=KINDS, help="kind to try (default: all)")
    parser.add_argument("--processes", type=int, default=2, help="parallel (default: 2)")
    parser.add_argument("--anew", action="store_true", help="discard earlier outcomes")
    parser.add_argument("--write", action="store_true", help="update the documentation page")
    parser.add_argument("--show", nargs=2, metavar=("KIND", "NUMBER"), help="one input")
    parser.add_argument("--chunk", nargs=2, help=argparse.SUPPRESS)
    args = parser.parse_args(words)
    if args.chunk:
        child(args.chunk[0], Path(args.chunk[1]))
        return 0
    if args.show:
        show(args.show[0], int(args.show[1]))
        return 0
    state = {} if args.anew else read_state()
    with suppress(KeyboardInterrupt):
        campaign(args.kind or KINDS, args.texts, args.processes, state)
    text = "\n".join(
        [f"Latest results ({datetime.now(UTC).date()}, `make fuzz`):", "", *table(state), ""]
    )
    print(text)
    found = causes(state)
    for sentence in found:
        print(sentence, file=sys.stderr)
    if args.write:
        put("make fuzz", text)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
