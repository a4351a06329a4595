"""Represent and validate the scale and columns of a published table.

Only input that cannot be parsed is an error. Impossible numbers, such as a mean outside the scale,
are findings, which `constraints.targets` reports.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import ceil, floor, isqrt, sqrt
from typing import Annotated, Literal, get_args

from pydantic import BeforeValidator, Field, field_validator, model_validator

from slipscale.analysis.published.printed_numbers import Printed
from slipscale.analysis.reconstruction.table.printed_fields import (
    AsPrinted,
    Counts,
    Exact,
    Shares,
    Values,
    exact,
)
from slipscale.faults.frozen_table import FrozenTable

Convention = Literal["sample", "population"]
CONVENTIONS: tuple[Convention, ...] = get_args(Convention)
# Designs: columns from the same participants, or from different participants.
Design = Literal["paired", "independent"]
# Maximum range of ratings, in steps, if the paper does not state the scale.
WIDEST_OPEN = 1_000_000_000
# Maximum sum of squares in steps, so that it fits in a machine integer.
LARGEST_SQUARES = 2**63 - 1


class OpenScale(FrozenTable):
    """A rating scale as published, possibly without a minimum or maximum.

    If ``items`` is given, each rating is the mean of the answers to this number of items. In the
    input, ``step`` is the step between possible answers to one item; it is stored as the step
    between possible ratings. If ``continuous`` is true, any value between the minimum and the
    maximum is possible, and data sets are not counted.

    Raises
    ------
    ValueError
        If the step does not divide the scale, or if the maximum is not above the minimum.
    """

    minimum: Exact | None = None
    maximum: Exact | None = None
    step: Exact = Fraction(1)
    items: Annotated[int, Field(ge=1, le=1000)] = 1
    continuous: bool = False

    @model_validator(mode="before")
    @classmethod
    def _mean_of_items(cls, given: object) -> object:
        """Convert the step of the answers to one item to the step of the mean over all items."""
        items = given.get("items") if isinstance(given, dict) else None
        # The field's validation rejects anything other than a number above 0.
        if not isinstance(given, dict) or not str(items).isdecimal() or not int(str(items)):
            return given
        return given | {"step": exact(given.get("step", 1)) / int(str(items))}

    @model_validator(mode="after")
    def _whole_steps(self) -> OpenScale:
        if self.continuous and {"step", "items"} & self.model_fields_set:
            raise ValueError("continuous values have no step: omit step and items")
        if self.step <= 0:
            raise ValueError(f"step must be above 0, but is {self.step}")
        if self.maximum is None:
            return self
        low = self.minimum or Fraction(0)
        if self.maximum <= low:
            raise ValueError(f"maximum must be above minimum {low}, but is {self.maximum}")
        if not self.continuous and (self.maximum - low) % self.step:
            raise ValueError(
                f"step {self.step} does not divide the scale from {low} to "
                f"{self.maximum}; expected a whole number of steps"
            )
        return self


class Scale(OpenScale):
    """A complete rating scale, from `minimum` to `maximum` in steps of `step`."""

    minimum: Exact = Fraction(0)
    maximum: Exact

    @property
    def steps(self) -> int:
        """Number of steps from the minimum to the maximum."""
        return int((self.maximum - self.minimum) / self.step)

    def too_fine(self, n: int) -> bool:
        """Return whether the sum of squares of n ratings could exceed `LARGEST_SQUARES`."""
        return n * self.steps**2 > LARGEST_SQUARES

    def value(self, steps: int) -> Fraction:
        """Return the rating that lies a number of steps above the minimum."""
        return self.minimum + steps * self.step

    def steps_to(self, value: Fraction) -> int | None:
        """Convert a rating to steps above the minimum, or return None if it is not on the scale."""
        steps = (value - self.minimum) / self.step
        inside = steps.denominator == 1 and 0 <= steps <= self.steps
        return int(steps) if inside else None


class Summary(FrozenTable):
    """The published numbers of one column, without its scale.

    Parameters
    ----------
    label : str
        Heading of the column.
    n : int
        Number of ratings, 2 or more.
    mean, mean_percent, sum : Printed, optional
        Mean of the ratings, their mean in percent (for ratings from 0 to 1), or their sum. At least
        one of these numbers is required, unless `geometric_mean` is given. Trailing zeros count as
        published decimals.
    sd, se : Printed, optional
        Standard deviation, and standard error of the mean (the SD divided by the square root of n).
    geometric_mean, log_sd : Printed, optional
        Geometric mean and SD of logarithms, which replace the mean and the SD.
    log_base : {"10", "2", "e"}
        Base of the logarithms.
    ci_low, ci_high : Printed, optional
        Ends of the confidence interval of the mean.
    ci_percent : float
        Confidence level in percent.
    ci_quantile : {"t", "normal"}
        Distribution used for the quantile of the confidence interval.
    sd_convention : {"sample", "population"}
        Whether SD and SE divide by n - 1 or by n.
    rounding : {"nearest", "half_up", "half_even", "truncated"}
        Rounding rule of all published numbers of the column.
    maximum_deviation : Printed, optional
        Largest distance of a rating from the unrounded mean.
    observed_minimum, observed_maximum : Printed, optional
        Smallest and largest rating that a participant gave.
    median : Printed, optional
        Middle rating, or mean of the two middle ratings if n is even.
    lower_quartile, upper_quartile : Printed, optional
        Quartiles by any common definition (see `quartiles`).
    present, absent : tuple of Fraction
        Ratings that at least one participant gave, and ratings that no participant gave.
    frequencies : tuple of (Fraction, int)
        Ratings, each with the number of participants who gave it.
    percentages : tuple of (Fraction, Printed)
        Ratings, each with the percentage of participants who gave it.
    amplitude_um_pp : float, optional
        Vibration amplitude in µm peak to peak, for computing exponents.
    """

    label: str = ""
    n: Annotated[int, Field(ge=2, le=1_000_000)]
    mean: AsPrinted | None = None
    mean_percent: AsPrinted | None = None
    sum: AsPrinted | None = None
    sd: AsPrinted | None = None
    se: AsPrinted | None = None
    geometric_mean: AsPrinted | None = None
    log_sd: AsPrinted | None = None
    log_base: Annotated[Literal["10", "2", "e"], BeforeValidator(str)] = "10"
    ci_low: AsPrinted | None = None
    ci_high: AsPrinted | None = None
    ci_percent: Annotated[float, Field(gt=0, lt=100, allow_inf_nan=False)] = 95.0
    ci_quantile: Literal["t", "normal"] = "t"
    sd_convention: Convention = "sample"
    rounding: Literal["nearest", "half_up", "half_even", "truncated"] = "nearest"
    maximum_deviation: AsPrinted | None = None
    observed_minimum: AsPrinted | None = None
    observed_maximum: AsPrinted | None = None
    median: AsPrinted | None = None
    lower_quartile: AsPrinted | None = None
    upper_quartile: AsPrinted | None = None
    present: Values = ()
    absent: Values = ()
    frequencies: Counts = ()
    percentages: Shares = ()
    amplitude_um_pp: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None

    @field_validator("sd", "se", "log_sd", "maximum_deviation")
    @classmethod
    def _not_negative(cls, printed: Printed | None) -> Printed | None:
        if printed and printed.value < 0:
            raise ValueError("expected 0 or more")
        return printed

    @model_validator(mode="after")
    def _enough(self) -> Summary:
        if bool(self.geometric_mean) != bool(self.log_sd):
            raise ValueError("geometric_mean and log_sd must be given together")
        if not (self.mean or self.mean_percent or self.sum or self.geometric_mean):
            raise ValueError("expected a mean, a mean_percent, a sum or a geometric_mean")
        if self.geometric_mean and (self.mean or self.mean_percent or self.sum or self.sd):
            raise ValueError("geometric_mean and log_sd describe logarithms: omit mean, sum and sd")
        if bool(self.ci_low) != bool(self.ci_high):
            raise ValueError("both ends of the confidence interval must be given together")
        stated = [value for value, _ in (*self.frequencies, *self.percentages)]
        stated += [*self.present, *self.absent]
        for value, times in Counter(stated).items():
            if times > 1:
                raise ValueError(
                    f"the rating {value} occurs {times} times in frequencies, percentages, present "
                    "and absent; expected each rating at most once"
                )
        return self

    @property
    def quantile(self) -> float:
        """Half-width of the confidence interval, divided by the standard error."""
        from scipy.special import ndtri, stdtrit

        p = 0.5 + self.ci_percent / 200
        return float(stdtrit(self.n - 1, p) if self.ci_quantile == "t" else ndtri(p))

    def means(self) -> Iterator[tuple[Printed, Fraction]]:
        """Yield the published mean, percentage and sum, each with its ratio to the mean."""
        for printed, factor in (
            (self.mean, Fraction(1)),
            (self.mean_percent, Fraction(100)),
            (self.sum, Fraction(self.n)),
        ):
            if printed is not None:
                yield printed, factor


class Column(Summary):
    """A column of a published table, with its published numbers and its scale.

    ``assumed`` lists properties that the table does not state: ``step`` (assumed to be 1),
    ``minimum`` and ``maximum`` (derived from the SD), and ``sd_convention`` (assumed to be
    "sample").
    """

    scale: Scale
    assumed: tuple[str, ...] = ()

    @property
    def scale_is_printed(self) -> bool:
        """Whether the table states at least one end of the scale."""
        return not {"minimum", "maximum"} <= set(self.assumed)

    @model_validator(mode="after")
    def _on_the_scale(self) -> Column:
        if self.scale.too_fine(self.n):
            most = isqrt(LARGEST_SQUARES // self.n)
            raise ValueError(
                f"the scale has {self.scale.steps:,} steps of {self.scale.step}; expected at "
                f"most {most:,} for n = {self.n:,}"
            )
        stated = [value for value, _ in (*self.frequencies, *self.percentages)]
        for value in (*stated, *self.present, *self.absent):
            if ((value - self.scale.minimum) / self.scale.step).denominator != 1:
                raise ValueError(
                    f"the rating {value} is not on the scale, which has steps of "
                    f"{self.scale.step} from {self.scale.minimum}"
                )
        return self


def close(summary: Summary, scale: OpenScale) -> Column:
    """Return the column with its published scale, or with the widest scale that its SD allows.

    Ratings have bounds even if no scale was published. According to Samuelson (1968), the squared
    distance of any rating from the mean is at most (n - 1) / n of the sum of squared deviations.

    Raises
    ------
    ValueError
        If neither a scale nor an SD limits the ratings, or if ratings are not on the scale.
    """
    given = {name: getattr(summary, name) for name in summary.model_fields_set}
    low = Fraction(0) if scale.minimum is None and scale.maximum is not None else scale.minimum
    high, farthest = scale.maximum, None
    if low is None or high is None:
        farthest = _farthest(summary)
        if farthest is None:
            raise ValueError("expected a scale (minimum and maximum), an sd or an se")
        printed, factor = next(summary.means())
        mean = printed.values(summary.rounding).scaled(1 / factor)
        step, origin = scale.step, low or Fraction(0)
        if low is None:
            low = origin + step * floor((mean.low - farthest - origin) / step)
        if high is None:
            high = max(origin + step * ceil((mean.high + farthest - origin) / step), low + step)
        if (high - low) / step > WIDEST_OPEN:
            raise ValueError(
                "expected a scale, because ratings without a scale may be almost any number"
            )
    grid = Scale(minimum=low, maximum=high, step=scale.step).model_copy(
        update={"items": scale.items}
    )
    assumed = [name for name in ("minimum", "maximum") if getattr(scale, name) is None]
    if farthest is None and "minimum" in assumed:
        assumed.remove("minimum")
    if "step" not in scale.model_fields_set:
        assumed.append("step")
    if summary.sd is not None and "sd_convention" not in summary.model_fields_set:
        assumed.append("sd_convention")
    return Column(**given, scale=grid, assumed=tuple(assumed))


def on_one_scale(columns: Sequence[Column]) -> tuple[Column, ...]:
    """Set a common scale for columns without a published scale, so that they can be compared."""
    grids = [column.scale for column in columns]
    if len({grid.step for grid in grids}) != 1:
        return tuple(columns)
    ends = {"minimum": min(g.minimum for g in grids), "maximum": max(g.maximum for g in grids)}
    grid = grids[0].model_copy(update=ends)
    if any(grid.too_fine(column.n) for column in columns):
        return tuple(columns)
    return tuple(column.model_copy(update={"scale": grid}) for column in columns)


def _farthest(summary: Summary) -> Fraction | None:
    """Return a bound on the distance of a rating from the mean, or None if there is no SD or SE."""
    if summary.sd is not None:
        sd = summary.sd.values(summary.rounding).high
    elif summary.se is not None:
        # The square root of n is rounded up, so that the bound remains valid.
        sd = summary.se.values(summary.rounding).high * Fraction(sqrt(summary.n) + 1e-6)
    else:
        return None
    # √n exceeds the exact factors, (n - 1) / √n for a sample SD and √(n - 1) for a population SD.
    return sd * Fraction(sqrt(summary.n) + 1e-6)
