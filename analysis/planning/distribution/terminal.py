"""Print the results of many simulated studies, and describe them in sentences."""

from __future__ import annotations

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from slipscale.analysis.planning.distribution.distribution import Distribution, Spread
from slipscale.analysis.planning.distribution.figures import STATISTICS
from slipscale.analysis.published import biet2007


def percent(share: float) -> str:
    """Format a proportion in per cent.

    >>> percent(0.254)
    '25 %'
    """
    return f"{100 * share:.0f} %"


def values(spread: Spread) -> tuple[str, str, str, str]:
    """Format the number of studies, the median, and the 5th and 95th percentiles."""
    numbers = (spread.median, spread.p5, spread.p95)
    median, p5, p95 = (f"{value:.4g}" for value in numbers)
    return str(spread.studies), median, p5, p95


def sentences(found: Distribution) -> list[str]:
    """Describe the simulation, and how to repeat one of the studies."""
    number = len(found.results)
    how = (
        f"as full sessions, because {found.sessions}" if found.sessions else "question by question"
    )
    whose = f"with people from population “{found.population}”"
    first = found.results[0].seed
    lines = [
        (
            f"{number} studies of {found.participants} participants each, {whose}, were simulated "
            f"{how} and analysed as in slipscale analyse. No person took part."
        ),
        (
            f"All seeds are derived from the seed {found.seed}. To repeat the first study as a "
            f"pilot, use slipscale pilot --seed {first}; studies.csv lists the seeds of all "
            "studies."
        ),
    ]
    if found.study == biet2007.STUDY and found.levels:
        lines.append(_paper(found))
    lines += [
        f"{count} of {number} studies could not be analysed and count as studies in which no "
        f"conclusion holds: {reason}."
        for reason, count in found.refused.items()
    ]
    return lines


def _paper(found: Distribution) -> str:
    """Report how many published cells of Table III lie within the simulated range."""
    inside = total = 0
    for amplitude in found.levels:
        row = biet2007.BY_AMPLITUDE.get(amplitude)
        for statistic in STATISTICS:
            cell = found.cell(amplitude, statistic)
            if row is None or cell is None:
                continue
            total += 1
            inside += cell.p5 <= float(getattr(row, statistic)) <= cell.p95
    return (
        f"{inside} of the {total} published cells are between the 5th and 95th percentiles of the "
        "simulated studies."
    )


def print_distribution(found: Distribution) -> None:
    """Print the spread of each cell of Table III, the main results, and the conclusions."""
    target = Console()
    head = {"title_justify": "left", "title_style": "bold", "box": box.SIMPLE_HEAD}
    if found.levels:
        cells = Table(title="Table III: median (5th to 95th percentile of the studies)", **head)  # type: ignore[arg-type]
        cells.add_column(f"{found.quantity.name}\n{found.quantity.unit_in_short}", justify="right")
        for title in STATISTICS.values():
            cells.add_column(title.lower(), justify="right", no_wrap=True)
        for amplitude in found.levels:
            row = [found.cell(amplitude, statistic) for statistic in STATISTICS]
            texts = [f"{c.median:.1f} ({c.p5:.1f} to {c.p95:.1f})" if c else "–" for c in row]
            cells.add_row(f"{amplitude:g}", *texts)
        target.print(cells)
    if found.headlines:
        chief = Table(title="Main results", **head)  # type: ignore[arg-type]
        chief.add_column("")
        for title in ("studies", "median", "5 %", "95 %"):
            chief.add_column(title, justify="right")
        for spread, words in found.headlines:
            chief.add_row(escape(words), *values(spread))
        target.print(chief)
    if found.conclusions:
        shares = Table(title="Proportion of studies in which each conclusion holds", **head)  # type: ignore[arg-type]
        shares.add_column("")
        shares.add_column("studies", justify="right", no_wrap=True)
        for each in found.conclusions:
            shares.add_row(escape(each.words), percent(each.share.value))
        target.print(shares)
    for line in sentences(found):
        target.print(line, markup=False, highlight=False)
