"""Declare statistics: what each needs, how it is computed, and the results of all.

One declaration contains everything about a statistic that the report, its files, a
pre-registration and a pilot need. Rules:

- a statistic that the study did not choose, or that the data do not support, is a `NotComputed`
  with the reason; no other code decides this;
- results are looked up by their declaration, as in ``inference[FRIEDMAN]``, so that their type is
  known.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Generic, TypeVar, cast

from slipscale.analysis.statistics.not_computed import NotComputed, computed

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    import pandas as pd

    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.experiments.study.analysis_choices import Primary
    from slipscale.stimuli.quantity import Quantity

T = TypeVar("T")
#: Covariant, so that statistics of several types fit in one list. This is sound because only
#: results of a statistic are passed to its callables.
T_co = TypeVar("T_co", covariant=True)

#: A session measure: name, unit, and values with participants as rows and sessions as columns.
SessionTable = tuple[str, str, "pd.DataFrame"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """Input data shared by all statistics.

    Parameters
    ----------
    data : Dataset
        The data set after exclusions.
    prepared : Prepared or None
        Magnitude estimates; None if there are none.
    rule : str or None
        Normalisation rule; None without estimates.
    bayesian : bool
        Whether to sample the hierarchical Bayesian power function, which takes half a minute.
    session_tables : callable
        Returns the session measures of every kind of task.
    found : Inference
        The results of the statistics declared before this one.
    """

    data: Dataset
    prepared: Prepared | None
    rule: str | None
    bayesian: bool = False
    session_tables: Callable[[], Iterable[SessionTable]] = tuple
    found: Inference


@dataclass(frozen=True, slots=True, kw_only=True)
class Family(Generic[T_co]):
    """Tests of one kind, shown in one row of the list of all tests.

    Parameters
    ----------
    name : str
        What is tested and how, for a quantity ``q``.
    read : callable
        Returns the uncorrected p-values of a result.
    primary : {"ranks", "logarithms"}, optional
        The primary analysis to which the family belongs.
    corrected : bool
        Whether Holm's correction is applied to its tests.
    """

    name: str
    read: Callable[[T_co], Sequence[float]]
    primary: Primary | None = None
    corrected: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Sentence(Generic[T_co]):
    """A report sentence about a result.

    Parameters
    ----------
    write : callable
        Returns the sentence, given the result, the confidence level and the quantity; None if
        there is nothing to report.
    primary : {"ranks", "logarithms"}, optional
        The primary analysis to which the sentence belongs; with any other, it is secondary.
    """

    write: Callable[[T_co, float, Quantity], str | None]
    primary: Primary | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Statistic(Generic[T_co]):
    """A statistic, written as one entry of ``inference.json``.

    Parameters
    ----------
    key : str
        Key in ``inference.json``, and name in a study's ``tests``.
    meaning : str
        Description of what is computed, for a pre-registration.
    compute : callable
        Returns the result, or the reason why there is none.
    test : bool
        Whether a study can omit it.
    title : str
        Name in the list of tests that could not be computed; if empty, it is not listed.
    parts : callable, optional
        Returns the parts of a result that can be missing separately, keyed by title, for a
        quantity ``q``.
    families : tuple of Family
        The tests that the report evaluates by p-values. Estimates with intervals have no family.
    sentences : tuple of Sentence
        Report sentences, in the order of the results section.
    methods : str
        Sentence for the methods section, for a quantity ``q``, with references as ``[[key]]``.
    conclusions, headlines : Mapping
        For simulated pilots: regular expression for names below the key -> description, for
        conclusions and for the numbers plotted. ``{0}`` is the first group of the expression.
    """

    key: str
    meaning: str
    compute: Callable[[Inputs], T_co | NotComputed]
    test: bool = True
    title: str = ""
    parts: Callable[[T_co], Mapping[str, object]] | None = None
    families: tuple[Family[T_co], ...] = ()
    sentences: tuple[Sentence[T_co], ...] = ()
    methods: str = ""
    conclusions: Mapping[str, str] = field(default_factory=dict)
    headlines: Mapping[str, str] = field(default_factory=dict)

    def __reduce__(self) -> tuple[Callable[[str], object], tuple[str]]:
        """Pickle the declaration as its key, because its functions cannot be pickled."""
        return _statistic_of, (self.key,)


def _statistic_of(key: str) -> object:
    # Looked up by name when unpickling, because the declarations import this module.
    kinds = import_module("slipscale.analysis.tasks.outside.guard").every_kind()
    return next(each for kind in kinds for each in kind.statistics if each.key == key)


@dataclass(frozen=True, slots=True)
class Inference:
    """The result of every statistic, or why there is none, in the order of ``inference.json``.

    Examples
    --------
    Code looks up a result by its declaration, ``inference[FRIEDMAN]``. In a notebook, the key is
    shorter: ``analysis.inference.friedman``.
    """

    results: Mapping[str, object] = field(default_factory=dict)
    #: The statistics computed, in the same order.
    declared: tuple[Statistic[object], ...] = ()

    def __getitem__(self, statistic: Statistic[T]) -> T | NotComputed:
        """Return the result, or the reason why there is none."""
        return cast("T | NotComputed", self.results[statistic.key])

    def found(self, statistic: Statistic[T]) -> T | None:
        """Return the result; None if there is none."""
        result = self[statistic]
        return computed(result)

    def __getattr__(self, key: str) -> object:
        """Return a result by its key, for notebooks."""
        try:
            return self.results[key]
        except KeyError:
            raise AttributeError(f"no statistic has the key '{key}'") from None

    def __dir__(self) -> Iterator[str]:
        """List the keys, for completion."""
        return iter([*object.__dir__(self), *self.results])

    def json_form(self) -> Mapping[str, object]:
        """Return the results by key."""
        return self.results

    def with_result(self, statistic: Statistic[object], result: object) -> Inference:
        """Return the results with one more result added."""
        results = {**self.results, statistic.key: result}
        return Inference(results, (*self.declared, statistic))


def of_estimates(
    test: Callable[[Prepared], T | NotComputed],
) -> Callable[[Inputs], T | NotComputed]:
    """Return a function that computes a test of magnitude estimates from all inputs."""

    def compute(inputs: Inputs) -> T | NotComputed:
        if inputs.prepared is None:
            return NotComputed("no magnitude estimates")
        return test(inputs.prepared)

    return compute
