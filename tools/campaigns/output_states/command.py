"""Run random histories of a plate on every backend, and compare them with the drive's true state.

Usage: ``python -m tools.campaigns output_states [--histories 10000]`` (an hour). A history is a
sequence of commands, rejected commands and events on the rig, such as a lost connection, a key
pressed on a generator, a broken sensor or a finger on the plate. After each command, two guarantees
of `slipscale.hardware.driver` are checked:

1. After a successful presentation, its amplitude is on the plate (within 5 % or 0.06 µm p-p).
2. An output that is *confirmed off* is off. After a command has failed, the output is not in the
   state *may be on*. After `close`, the output is off or *unreachable*.

The exit status is 1 if a guarantee was violated.
"""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace

from tools.campaigns.output_states.histories import lived
from tools.campaigns.output_states.rigs import HISTORIES, RIGS


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the campaign."""
    parser.add_argument("--histories", type=int, default=HISTORIES, help="per backend")
    parser.add_argument("--backend", choices=RIGS, action="append")


def run(arguments: Namespace) -> tuple[int, str]:
    """Run the campaign."""
    broken = 0
    for backend in arguments.backend or RIGS:
        begun_s, presented, faults, wrong = time.monotonic(), 0, 0, []
        for seed in range(arguments.histories):
            history = lived(backend, seed)
            presented, faults = presented + history.presented, faults + history.faults
            wrong += [f"seed {seed}: {each}" for each in history.broken]
        print(
            f"{backend}: {arguments.histories} histories, {presented} presentations, {faults} "
            f"faults, {len(wrong)} violations, {time.monotonic() - begun_s:.0f} s", flush=True
        )  # fmt: skip
        print(*wrong[:5], sep="\n", end="\n" if wrong else "")
        broken += len(wrong)
    return int(broken > 0), ""
