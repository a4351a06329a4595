"""Define how a statistic is declared and how results are stored.

A declaration contains everything about a statistic that is needed for the report, its files, a
pre-registration and a pilot. Rules:

- a statistic is the instance of its own class, so that it can be pickled;
- if the study did not choose a statistic, or the data do not support it, its result is a
  `NotComputed` with the reason;
- results are looked up by declaration, as in ``inference[FRIEDMAN]``, so that type checkers can
  infer their type.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Generic, TypeVar, cast

from slipscale.analysis.statistics.not_computed import NotComputed, computed

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.experiments.study.analysis_choices import Primary
    from slipscale.stimuli.quantity import Quantity

T = TypeVar("T")
#: The type is covariant, so that a list can contain statistics of several types. This is safe
#: because the methods of a statistic receive only its own results.
T_co = TypeVar("T_co", covariant=True)

#: A session measure: name, unit, and a table of participants (rows) by sessions (columns).
SessionTable = tuple[str, str, "pd.DataFrame"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """The input data for all statistics.

    Parameters
    ----------
    data : Dataset
        The data set after exclusion of trials and participants.
    prepared : Prepared or None
        Magnitude estimates, or None if the data set contains none.
    rule : str or None
        Normalisation rule, or None if there are no magnitude estimates.
    bayesian : bool
        Whether to sample the hierarchical Bayesian power function, which takes half a minute.
    session_tables : callable
        Function that returns one `SessionTable` for each measure of each kind of task.
    found : Inference
        The results of all statistics that are declared before the current one.
    """

    data: Dataset
    prepared: Prepared | None
    rule: str | None
    bayesian: bool = False
    session_tables: Callable[[], Iterable[SessionTable]] = tuple
    found: Inference


@dataclass(frozen=True, slots=True, kw_only=True)
class Family(Generic[T_co]):
    """A family of tests, shown as one row in the report's list of tests.

    Parameters
    ----------
    name : str
        Hypothesis and test method. In the placeholders, ``q`` is the quantity of the stimuli, as in
        ``{q.levels}``.
    read : callable
        Function that returns the uncorrected p-values of a result.
    primary : {"ranks", "logarithms"}, optional
        Primary analysis to which the family belongs. If omitted, the tests are secondary in every
        analysis.
    corrected : bool
        Whether the p-values of the family are Holm-corrected.
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
        Function that takes the result, the confidence level and the quantity of the stimuli, and
        returns the sentence, or None if there is nothing to report.
    primary : {"ranks", "logarithms"}, optional
        Primary analysis to which the sentence belongs. If omitted, the sentence describes a
        secondary result in every analysis.
    """

    write: Callable[[T_co, float, Quantity], str | None]
    primary: Primary | None = None


class Declaration:
    """A definition whose content are the methods and attributes of its class.

    The instance is pickled as the name of its class, and equals the copy of another process.
    """

    def __eq__(self, other: object) -> bool:
        """Compare the classes, and attributes that were set when the instances were created."""
        return type(self) is type(other) and vars(self) == vars(other)

    def __hash__(self) -> int:
        """Return the same value for all instances of a class."""
        return hash(type(self))


@dataclass(frozen=True, slots=True)
class Named:
    """A description of the results at a path.

    Parameters
    ----------
    path : str
        Keys in the result of the statistic, joined by dots. ``*`` is any key, or any element of a
        list.
    words : str
        Description, in which ``{0}`` is the first key or element at a ``*``, and ``{0[0]}`` the
        first of the values that identify the element.
    """

    path: str
    words: str


class Statistic(Declaration, Generic[T_co]):
    """The declaration of a statistic, whose result is one entry of ``inference.json``.

    Attributes
    ----------
    key : str
        Key in ``inference.json``, which is also used in the ``tests`` of a study file.
    meaning : str
        Description of the computation, for use in a pre-registration.
    test : bool
        Whether the statistic is optional, so that a study file may omit it from ``tests``.
    title : str
        Title in the list of tests that could not be computed. If the title is empty, the statistic
        is not listed.
    families : tuple of Family
        Families of tests with p-values, listed in the report. Estimates with confidence intervals
        do not belong to a family.
    sentences : tuple of Sentence
        Sentences for the results section, in order.
    methods : str
        Sentence for the methods section, which can contain placeholders such as ``{q.levels}``, and
        references as ``[[key]]``.
    conclusions, headlines : tuple of Named
        Conclusions and main results that are summarised over simulated pilots.
    """

    key: str
    meaning: str
    test: bool = True
    title: str = ""
    families: tuple[Family[T_co], ...] = ()
    sentences: tuple[Sentence[T_co], ...] = ()
    methods: str = ""
    conclusions: tuple[Named, ...] = ()
    headlines: tuple[Named, ...] = ()

    def compute(self, inputs: Inputs, /) -> T_co | NotComputed:
        """Return the result, or the reason why there is none."""
        raise NotImplementedError

    def parts(self, _found: T_co) -> Mapping[str, object]:  # type: ignore[misc]  # its own result
        """Divide a result into parts, some of which may be `NotComputed`, keyed by title.

        Titles can contain placeholders such as ``{q.levels}``.
        """
        return {}


@dataclass(frozen=True, slots=True)
class Inference:
    """The results of all statistics, in the order of ``inference.json``.

    Examples
    --------
    Results are available by declaration, as in ``inference[FRIEDMAN]``, and by key, as in
    ``analysis.inference.friedman``, which is shorter in a notebook.
    """

    results: Mapping[str, object] = field(default_factory=dict)
    #: Declarations of the statistics, in the same order.
    declared: tuple[Statistic[object], ...] = ()

    def __getitem__(self, statistic: Statistic[T]) -> T | NotComputed:
        """Return the result of a statistic, or the reason why there is none."""
        return cast("T | NotComputed", self.results[statistic.key])

    def found(self, statistic: Statistic[T]) -> T | None:
        """Return the result of a statistic, or None if it is missing."""
        result = self[statistic]
        return computed(result)

    def __getattr__(self, key: str) -> object:
        """Return a result by its key, for convenience in notebooks."""
        try:
            return self.results[key]
        except KeyError:
            raise AttributeError(f"no statistic has the key '{key}'") from None

    def __dir__(self) -> Iterator[str]:
        """List the keys of all results, for tab completion in notebooks."""
        return iter([*object.__dir__(self), *self.results])

    def json_form(self) -> Mapping[str, object]:
        """Return a mapping of keys to results."""
        return self.results

    def with_result(self, statistic: Statistic[object], result: object) -> Inference:
        """Return a copy with one result added."""
        results = {**self.results, statistic.key: result}
        return Inference(results, (*self.declared, statistic))


def of_estimates(
    test: Callable[[Prepared], T | NotComputed],
) -> staticmethod[[Inputs], T | NotComputed]:
    """Adapt a test of magnitude estimates for use as `Statistic.compute`."""

    def compute(inputs: Inputs) -> T | NotComputed:
        if inputs.prepared is None:
            return NotComputed("no magnitude estimates")
        return test(inputs.prepared)

    return staticmethod(compute)
