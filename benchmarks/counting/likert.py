"""Counting the data sets behind Likert columns, beside closure-core's counter, in one run.

    python benchmarks/counting/likert.py --closure-core PATH/TO/src/count.rs

The file is part of closure-core (MIT or Apache 2.0), repository lhdjung/closure-core on GitHub; it
needs no other file, and `rustc` builds it in a temporary folder. Without the file or `rustc` the
peer is skipped by name.

Ours is timed from the column as read to the count, GRIM and GRIMMER included; the peer from its
arguments to its result, inside its own process. Best of several runs each, one thread.
"""

from __future__ import annotations

import argparse
import random
import shutil
import subprocess
import tempfile
import time
from fractions import Fraction
from pathlib import Path

from slipscale.analysis.reconstruction.data_sets.batch import verdict
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.table.published_table import Column, Scale
from slipscale.analysis.reconstruction.table.rounding import Printed
from slipscale.analysis.reconstruction.table.table_files import read_rows

# n, mean, SD and the scale's ends.
COLUMNS = [
    (20, "4.00", "1.52", 1, 7),
    (30, "3.50", "1.20", 1, 5),
    (50, "4.00", "1.50", 1, 7),
    (50, "3.24", "1.10", 1, 5),
    (50, "4.0", "1.5", 1, 7),
    (60, "5.00", "2.00", 1, 9),
    (60, "5.00", "2.00", 0, 10),
    (100, "3.20", "1.20", 1, 5),
    (100, "4.00", "1.50", 1, 7),
    (100, "4.0", "1.5", 1, 7),
    (130, "2.7", "1.9", 1, 5),
    (200, "4.00", "1.50", 1, 7),
]
ROWS = 1000
# Reads columns from its input, writes each count and its time.
HARNESS = """
mod count;
use std::time::Instant;
fn main() {
    let mut line = String::new();
    while std::io::stdin().read_line(&mut line).unwrap() > 0 {
        let x: Vec<f64> = line.split_whitespace().map(|word| word.parse().unwrap()).collect();
        let (mut best, mut found, mut runs) = (f64::INFINITY, 0, 0);
        let begun = Instant::now();
        while runs == 0 || (runs < 7 && begun.elapsed().as_secs_f64() < 2.0) {
            let start = Instant::now();
            found = count::closure_count(
                x[0], x[1], x[2] as i32, x[3] as i32, x[4] as i32, x[5], x[6]);
            best = best.min(start.elapsed().as_secs_f64());
            runs += 1;
        }
        println!("{} {}", found, best);
        line.clear();
    }
}
"""


def ours(facts: tuple[int, str, str, int, int]) -> tuple[int, float]:
    n, mean, sd, low, high = facts
    scale = Scale(minimum=Fraction(low), maximum=Fraction(high))
    column = Column(n=n, mean=Printed(mean), sd=Printed(sd), scale=scale)
    found, best = 0, float("inf")
    for _ in range(7):
        start = time.perf_counter()
        found = Solutions(column).multisets
        best = min(best, time.perf_counter() - start)
    return found, best


def theirs(source: Path) -> list[tuple[int, float]]:
    """Build the peer in a temporary folder and return its counts and times."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(source, Path(folder, "count.rs"))
        Path(folder, "main.rs").write_text(HARNESS, encoding="utf-8")
        build = ["rustc", "-O", "-A", "warnings", "main.rs", "-o", "counter"]
        subprocess.run(build, cwd=folder, check=True)
        lines = [
            f"{mean} {sd} {n} {low} {high} {float(Printed(mean).unit) / 2} "
            f"{float(Printed(sd).unit) / 2}"
            for n, mean, sd, low, high in COLUMNS
        ]
        ran = subprocess.run(
            [Path(folder, "counter")],
            input="\n".join(lines) + "\n",
            capture_output=True,
            text=True,
            check=True,
        )
    answers = (line.split() for line in ran.stdout.splitlines())
    return [(int(count), float(seconds)) for count, seconds in answers]


def batch() -> None:
    """Time a thousand rows as a batch judges them."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "rows.csv")
        path.write_text("\n".join(rows()) + "\n", encoding="utf-8")
        start, begun = time.perf_counter(), time.process_time()
        verdicts = [verdict(row, memory_gib=4.0, minutes=10.0) for row in read_rows(path)]
        seconds, busy = time.perf_counter() - start, time.process_time() - begun
    counted = sum(one.verdict == "consistent" for one in verdicts)
    print(
        f"\n{ROWS:,} Likert rows, {counted:,} consistent: {seconds:.2f} s in one process, "
        f"{busy:.2f} s of its processor"
    )


def rows() -> list[str]:
    """Return rows of a CSV: ratings drawn on 1 to 5 or 1 to 7, n from 20 to 150."""
    chance = random.Random(7)
    lines = ["label,n,mean,sd,scale_minimum,scale_maximum"]
    for row in range(ROWS):
        top, n, places = chance.choice([5, 7]), chance.randint(20, 150), chance.choice([1, 2, 2])
        centre, spread = chance.uniform(1.5, top - 0.5), chance.uniform(0.6, 1.8)
        x = [min(max(round(chance.gauss(centre, spread)), 1), top) for _ in range(n)]
        mean = sum(x) / n
        sd = (sum((v - mean) ** 2 for v in x) / (n - 1)) ** 0.5
        lines.append(f"row {row},{n},{mean:.{places}f},{sd:.{places}f},1,{top}")
    return lines


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="counting Likert columns beside closure-core")
    parser.add_argument("--closure-core", type=Path, metavar="FILE", help="its src/count.rs")
    source = parser.parse_args().closure_core
    peer = None
    if source is None or shutil.which("rustc") is None:
        print("skipped: closure-core (needs --closure-core src/count.rs, and rustc on the path)")
    else:
        peer = theirs(source)
    print("| column | data sets | ours, ms | closure-core, ms | times as long |")
    print("| --- | ---: | ---: | ---: | ---: |")
    for place, facts in enumerate(COLUMNS):
        count, seconds = ours(facts)
        n, mean, sd, low, high = facts
        line = f"| n {n} on {low} to {high}, {mean} ({sd}) | {count:,} | {1e3 * seconds:.2f} |"
        if peer:
            other, longer = peer[place]
            if other != count:
                raise SystemExit(f"{facts}: ours {count}, closure-core {other}")
            line += f" {1e3 * longer:.2f} | {longer / seconds:.1f} |"
        print(line)
    batch()
