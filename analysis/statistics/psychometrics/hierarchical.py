"""Fit the thresholds of a population and of each participant in one hierarchical model.

    p(level u, participant i, condition c) = guess + (1 - guess - lapse) G(a + s (u - m_ic))
    m_ic = x_ic β + τ b_i + ω e_ic,   log s_i = log s + ν d_i,   b, e and d standard normal

``u`` is the level's coordinate, ``G`` the curve and ``a`` its argument at the threshold. The lapse
rate is the same for all participants and is estimated from all answers. Slopes differ between
people: with a shared slope, the model would treat the errors of people with shallow curves as
lapses, and the typical curve would be too steep. With several conditions, ν is 0, because a third
integral would take seven times as long. The fit needs neither a prior nor narrow bounds, even if a
participant gave few answers. Catch trials present a level that nobody misses, so only lapses cause
errors in these trials, which contribute to the likelihood. The fitted parameters maximise the
marginal likelihood (see `integrated_over_people`). No package on PyPI fits a psychometric function
with lapses, random thresholds and random slopes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.statistics.psychometrics import psychometric_fit as likelihood
from slipscale.analysis.statistics.psychometrics.integrated_over_people import (
    FLAT,
    NO_EFFECT,
    Counted,
    IntegratedModel,
    Interval,
    Maximum,
    Prediction,
    even,
    students_fall,
)
from slipscale.analysis.statistics.psychometrics.psychometric_fit import Array, Model

#: Largest standard deviation between people, and largest distance of the threshold from the mean
#: level, in standard deviations of the levels.
WIDEST, FARTHEST = 5.0, 6.0
#: Longest and shortest rise of the curve, in standard deviations of the levels.
SHALLOWEST, STEEPEST = 20.0, 0.02
#: Nodes for differences between people's thresholds: number per square root of the largest number
#: of answers from one participant, minimum and maximum number, and extent in standard deviations.
#: Curves that may be steep need twice as many nodes.
NODES, FEWEST_NODES, MOST_NODES, OUTERMOST = 4.0, 21, 161, 4.0
#: Largest distance between neighbouring nodes, as a multiple of the curve's width divided by the
#: square root of the largest number of answers, and largest number of nodes of a refined grid. On a
#: coarser grid, a curve that is steeper than the grid can pass between the answers of everybody,
#: and the likelihood has maxima that are errors of the integral.
COARSEST, MOST_REFINED = 3.0, 801
#: Number of nodes for the deviation of a participant's threshold in one condition.
INNER_NODES = 21
#: Number of nodes of the grid that confirms a maximum, relative to the grid of the search.
FINER = 4
#: Nodes for slopes. A participant's answers hardly determine the slope, so nodes one standard
#: deviation apart are enough: with 41 nodes, estimates change by less than 0.1 standard errors.
OF_SLOPES = even(7, 3.0)
#: Largest standard deviation of log slopes between people.
MOST_UNLIKE = 1.5
#: Initial lapse rates (the likelihood can have a peak near each of them), and initial rise of the
#: curve in standard deviations of the levels.
LAPSES, WIDTHS = (0.005, 0.03, 0.1), (3.0, 1.5, 0.8)


@dataclass(frozen=True, slots=True, kw_only=True)
class Trials:
    """Answer counts from several people, with one row per person, condition and level.

    Parameters
    ----------
    person, condition : int array, shape (rows,)
        Indices of persons and of conditions, counted from 0.
    design : array, shape (rows, coefficients)
        Design matrix of the thresholds, whose rows are equal for the same person and condition.
    u : array, shape (rows,)
        Positions of the levels on the curve's axis. On a logarithmic axis, a level of 0 becomes
        `psychometric_fit.FAR_BELOW`.
    yes, n : array, shape (rows,)
        Number of correct (or "yes") answers, and number of all answers.
    catch_right, catch_wrong : int
        Number of correct and number of wrong answers in catch trials, over all participants.
    """

    person: NDArray[np.intp]
    condition: NDArray[np.intp]
    design: Array
    u: Array
    yes: Array
    n: Array
    catch_right: int = 0
    catch_wrong: int = 0


class HierarchicalFit:
    """A fitted hierarchical model with profile-likelihood confidence intervals.

    Parameters
    ----------
    model : Model
        Psychometric function: curve, value of the curve at the threshold, guess rate and largest
        lapse rate.
    trials : Trials
    start : array, optional
        Starting point of the search, if an approximate maximum is known.
    slopes_differ : bool
        Whether slopes differ between people. Ignored with several conditions.
    """

    def __init__(
        self,
        model: Model,
        trials: Trials,
        start: Array | None = None,
        *,
        slopes_differ: bool = True,
    ) -> None:
        self.model, self.trials = model, trials
        seen = trials.u[trials.u > likelihood.FAR_BELOW]
        self._centre = float(seen.mean())
        self._scale = float(seen.std()) or 1.0
        self.people = int(trials.person.max()) + 1
        keys = np.column_stack([trials.condition, trials.design, trials.u])
        kinds, kind = np.unique(keys, axis=0, return_inverse=True)
        shape = (self.people, len(kinds))
        yes, no = np.zeros(shape), np.zeros(shape)
        np.add.at(yes, (trials.person, kind), trials.yes)
        np.add.at(no, (trials.person, kind), trials.n - trials.yes)
        self._cells = kinds[:, 0].astype(int)
        self._design = kinds[:, 1:-1]
        self._u = (kinds[:, -1] - self._centre) / self._scale
        counted = Counted(yes=yes, no=no, cells=self._cells, times=np.ones(self.people))
        self.coefficients = self._design.shape[1]
        several = len(np.unique(self._cells)) > 1
        self.slopes_differ = slopes_differ and not several
        slopes = np.log(model.spread / np.array([SHALLOWEST, STEEPEST]))
        rate = model.guess_rate
        self._guess = {"fixed": (rate, rate), "free": (0.0, likelihood.LARGEST_GUESS)}.get(
            model.guess, (0.0, 0.0)
        )
        p = self.coefficients
        self.slope, self.spread, self.within, self.unlike, self.lapse, self.guess = range(p, p + 6)
        bounds = [(-FARTHEST, FARTHEST)] * p + [
            (float(slopes[0]), float(slopes[1])),
            (0.0, WIDEST),
            (0.0, WIDEST if several else 0.0),
            (0.0, MOST_UNLIKE if self.slopes_differ else 0.0),
            (0.0, model.largest_lapse),
            self._guess,
        ]

        def with_nodes(count: int, finer: int = 1) -> IntegratedModel:
            persons = even(min(finer * count, max(count, MOST_REFINED)), OUTERMOST)
            return IntegratedModel(
                counted,
                self._predict,
                bounds,
                spreads=(self.spread, self.within, self.unlike),
                outer=persons.crossed(OF_SLOPES if self.slopes_differ else NO_EFFECT),
                inner=even(finer * INNER_NODES) if several else NO_EFFECT,
                more=self._catches,
                finer=self._on_finer_grid if finer == 1 else None,
            )

        self._with_nodes = with_nodes
        nodes = (2 if self.slopes_differ else 1) * NODES * counted.most_answers**0.5
        self._nodes = int(np.clip(nodes, FEWEST_NODES, MOST_NODES))
        self._fitted = with_nodes(self._nodes)
        refined = True
        while refined:
            self.best = self._best() if start is None else self._fitted.fit(start)
            refined = self._refined(self.best)

    def _refined(self, found: Maximum) -> bool:
        """Take a finer grid, if the present one is too coarse for the curve that was found."""
        widths = found.theta[self.spread] * np.exp(found.theta[self.slope])
        most = self._fitted.counted.most_answers
        needed = 2 * OUTERMOST * widths * most**0.5 / COARSEST
        nodes = int(min(needed, MOST_REFINED))
        if nodes <= self._nodes:
            return False
        self._nodes, self._fitted = nodes, self._with_nodes(nodes)
        return True

    def _on_finer_grid(self, theta: Array) -> float:
        return -self._with_nodes(self._nodes, FINER).minus_log(theta)[0]

    def _best(self) -> Maximum:
        if self.slopes_differ:
            shared = HierarchicalFit(self.model, self.trials, slopes_differ=False)
            fits = self._fitted.fit(shared.best.theta), shared.best
            return max(fits, key=lambda one: one.log_likelihood)
        guess = sum(self._guess) / 2

        def start(lapse: float, width: float) -> Array:
            slope = np.log(self.model.spread / width)
            lapse = min(lapse, self.model.largest_lapse)
            return np.array([*np.zeros(self.coefficients), slope, 0.5, 0.3, 0.3, lapse, guess])

        starts = [
            min(
                (start(lapse, width) for width in WIDTHS),
                key=lambda q: self._fitted.minus_log(q)[0],
            )
            for lapse in LAPSES
        ]
        return max(map(self._fitted.fit, starts), key=lambda one: one.log_likelihood)

    def _catches(self, theta: Array) -> tuple[float, Array]:
        right, wrong = self.trials.catch_right, self.trials.catch_wrong
        lapse = float(np.clip(theta[self.lapse], likelihood.EDGE, 1))
        gradient = np.zeros(len(theta))
        gradient[self.lapse] = wrong / lapse - right / (1 - lapse)
        return right * np.log1p(-lapse) + wrong * np.log(lapse), gradient

    def _predict(self, theta: Array, outer: Array, inner: Array) -> Prediction:
        """Return log probabilities of correct and wrong answers, shape (kinds, outer, inner)."""
        model, (of_person, of_slope) = self.model, outer
        steep = np.exp(theta[self.slope] + theta[self.unlike] * of_slope)
        middle = self._design @ theta[: self.coefficients]
        at = middle[:, None, None] + theta[self.spread] * of_person + theta[self.within] * inner
        z = np.subtract(self._u[:, None, None], at, out=at)
        z *= steep
        z += model.offset
        share, equal = model.curve.distribution(z), model.guess == "equal to lapse"
        lapse = float(theta[self.lapse])
        guess = lapse if equal else float(theta[self.guess])
        height = 1 - guess - lapse
        p = height * share
        p += guess
        np.clip(p, likelihood.EDGE, 1 - likelihood.EDGE, out=p)

        def gradient(pull_yes: Array, pull_no: Array) -> Array:
            pull = pull_yes / p
            pull -= pull_no / (1 - p)
            rise = height * model.curve.density(z)
            rise *= pull
            down = -rise.sum(axis=2) * steep[:, 0]
            found = np.empty(len(theta))
            found[: self.coefficients] = self._design.T @ down.sum(axis=1)
            found[self.spread] = down.sum(axis=0) @ of_person[:, 0]
            found[self.within] = -steep[:, 0] @ rise.sum(axis=0) @ inner
            rise *= z - model.offset
            steeper = rise.sum(axis=(0, 2))
            found[self.slope] = steeper.sum()
            found[self.unlike] = steeper @ of_slope[:, 0]
            each, share_pull = pull.sum(), np.vdot(pull, share)
            found[self.lapse] = each - 2 * share_pull if equal else -share_pull
            found[self.guess] = 0.0 if equal else each - share_pull
            return found

        return Prediction(np.log(p), np.log1p(-p), gradient)

    def coordinates(self, coefficient: Array) -> Array:
        """Convert thresholds from internal units to positions on the axis of the levels."""
        return self._centre + self._scale * np.asarray(coefficient, float)

    def intervals(self, *places: int, df: int, confidence: float) -> tuple[Interval, ...]:
        """Return parameters' estimates and profile-likelihood intervals, in internal units.

        The search can find a higher maximum, which replaces `best`: all results belong to one fit.

        Parameters
        ----------
        places : int
            Indices of coefficients, or ``slope``, the index of the natural logarithm of the slope.
        df : int
            Degrees of freedom between people.
        """
        fall = students_fall(self.people, df, confidence)
        self.best, found = self._fitted.profiles(self.best, places, fall)
        if self._refined(self.best):
            self.best = self._best()
            return self.intervals(*places, df=df, confidence=confidence)
        return found

    def p(self, coefficient: int, df: int) -> float:
        """Return the p-value for the null hypothesis that a coefficient is 0."""
        from scipy import stats

        fallen = max(self.fallen({coefficient: 0.0}), 0.0)
        t = (df * np.expm1(2 * fallen / self.people)) ** 0.5
        return float(2 * stats.t.sf(t, df))

    def fallen(self, held: dict[int, float]) -> float:
        """Return the drop in log likelihood if the parameters in ``held`` are fixed."""
        return self.best.log_likelihood - self._fitted.fit(self.best.theta, held).log_likelihood

    @property
    def jumps(self) -> bool:
        """Whether the steepest allowed slope fits about as well as the best slope."""
        steepest = self._fitted.bounds[self.slope][1]
        held = self._fitted.fit(self.best.theta, {self.slope: steepest})
        near = self.best.log_likelihood - held.log_likelihood < FLAT
        return near and not self._fitted.higher(self.best.theta, held.theta)

    def deviations(self) -> Array:
        """Return each person's deviation from the population threshold, on the curve's axis.

        The estimate of a deviation is its conditional mean, given the person's answers and the
        fitted model. Estimates are shrunk towards 0, more strongly for people with fewer answers.
        """
        _, shares = self._fitted.posteriors(self.best.theta)
        return np.asarray(self.sd * (shares @ self._fitted.outer.nodes[0]))

    @property
    def sd(self) -> float:
        """Standard deviation of people's thresholds, on the curve's axis."""
        return self._scale * float(self.best.theta[self.spread])

    @property
    def scale(self) -> float:
        """Internal unit of the fit: the SD of the levels on the curve's axis (1 if the SD is 0)."""
        return self._scale
