"""Define the hierarchical power function, and draw from its posterior with NumPyro.

The model for the estimate y of participant i at stimulus x is as follows, where x0 and y0 are the
geometric means of all stimuli and estimates::

    log(y / y0) ~ Normal(a_i + b_i log(x / x0), s)
    (a_i, b_i)  ~ Normal((A, B), spreads (ta, tb), correlation r)
    A ~ Normal(0, 2.5)   B ~ Normal(0, 1.5)   r ~ LKJ(2)
    ta ~ HalfNormal(1)   tb ~ HalfNormal(0.5)   s ~ HalfNormal(1)

Published exponents of all senses lie between 0.3 and 3.5 (Stevens 1975, Psychophysics, ch. 1), and
people's exponents differ by less than a factor of e. The priors therefore cover almost all
published values.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.statistics.arrays import Array

#: Standard deviations of the priors.
PRIOR_SD = {"A": 2.5, "B": 1.5, "ta": 1.0, "tb": 0.5, "s": 1.0}
#: Concentration of the prior for the correlation.
LKJ = 2.0
CHAINS, WARM_UP, DRAWS = 4, 1000, 1000
#: Target acceptance rate of the sampler; a high rate keeps its steps small.
ACCEPTED = 0.95
#: Seed of the sampler, so that the same data give the same draws.
SEED = 2007


@dataclass(frozen=True, slots=True, kw_only=True)
class Trials:
    """Data for the model.

    Parameters
    ----------
    log_y, log_x : array, shape (trials,)
        Centred log estimates and log stimuli.
    who : int array, shape (trials,)
        Participant indices, from 0.
    names : tuple of str
        Participant names, in the order of the indices in ``who``.
    """

    log_y: Array
    log_x: Array
    who: NDArray[np.int64]
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Sums:
    """Sufficient statistics of each participant's trials.

    The design matrix X has two columns: the constant 1 and log x.

    Parameters
    ----------
    xx : array, shape (people, 2, 2)
        X'X.
    xy : array, shape (people, 2)
        X'log y.
    yy, trials : array, shape (people,)
        Sum of squares of log y, and number of trials.
    """

    xx: Array
    xy: Array
    yy: Array
    trials: Array


def sums(trials: Trials) -> Sums:
    """Return the sufficient statistics of each participant's trials."""
    people = len(trials.names)
    x = np.stack([np.ones_like(trials.log_x), trials.log_x], axis=1)

    def total(values: Array) -> Array:
        found = np.zeros((people, *values.shape[1:]))
        np.add.at(found, trials.who, values)
        return found

    return Sums(
        xx=total(x[:, :, None] * x[:, None, :]),
        xy=total(x * trials.log_y[:, None]),
        yy=total(trials.log_y**2),
        trials=total(np.ones(len(x))),
    )


def model(xx: Any, xy: Any, yy: Any, trials: Any) -> None:
    """Define the model for NumPyro.

    Participants' intercepts and exponents are integrated out analytically, because they are
    normally distributed given the other six parameters.
    """
    import numpyro
    from jax import numpy as jnp
    from numpyro import distributions as dist

    mean = jnp.stack(
        [numpyro.sample(name, dist.Normal(0.0, PRIOR_SD[name])) for name in ("A", "B")]
    )
    ta, tb, s = (
        numpyro.sample(name, dist.HalfNormal(PRIOR_SD[name])) for name in ("ta", "tb", "s")
    )
    # For two variables, the LKJ distribution is a scaled beta distribution.
    r = 2 * numpyro.sample("half_r", dist.Beta(LKJ, LKJ)) - 1
    factor = jnp.array([[ta, 0.0], [tb * r, tb * jnp.sqrt(1 - r**2)]])
    # Likelihood by Woodbury's identity: y is normal with mean X m and covariance s² I + X F F' X',
    # where m is ``mean`` and F is ``factor``.
    rest = xy - xx @ mean
    squares = yy - 2 * xy @ mean + (xx @ mean) @ mean
    inner = jnp.eye(2) + factor.T @ xx @ factor / s**2
    u, v = (rest @ factor).T
    p, q, w = inner[:, 0, 0], inner[:, 0, 1], inner[:, 1, 1]
    determinant = p * w - q**2
    explained = (w * u**2 - 2 * q * u * v + p * v**2) / determinant
    log_determinant = jnp.log(determinant) + 2 * trials * jnp.log(s)
    numpyro.factor("log_y", -0.5 * (log_determinant + (squares - explained / s**2) / s**2).sum())


@cache
def _chains(warm_up: int, draws: int) -> Any:
    """Return a function that samples several chains in parallel."""
    import jax
    from numpyro.infer import MCMC, NUTS

    def chain(key: object, *known: object) -> object:
        kernel = NUTS(model, target_accept_prob=ACCEPTED)
        sampler = MCMC(kernel, num_warmup=warm_up, num_samples=draws, progress_bar=False)
        sampler.run(key, *known, extra_fields=("diverging",))
        return sampler.get_samples(), sampler.get_extra_fields()["diverging"]

    return jax.jit(jax.vmap(chain, in_axes=(0, None, None, None, None)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Draws:
    """Draws from the posterior.

    Parameters
    ----------
    values : Mapping
        Arrays of shape (chains, draws, ...), keyed by parameter. ``own`` contains participants'
        intercepts and exponents and has shape (chains, draws, people, 2).
    divergences : int
        Number of divergent transitions.
    """

    values: Mapping[str, Array]
    divergences: int


def sample(
    trials: Trials,
    *,
    chains: int = CHAINS,
    warm_up: int = WARM_UP,
    draws: int = DRAWS,
    seed: int = SEED,
) -> Draws:
    """Sample the posterior."""
    import jax

    known = sums(trials)
    # Single precision is not sufficient for estimates with very little noise.
    with jax.enable_x64(True):
        keys = jax.random.split(jax.random.PRNGKey(seed), chains)
        drawn, diverging = _chains(warm_up, draws)(keys, known.xx, known.xy, known.yy, known.trials)
        found = {name: np.asarray(values, float) for name, values in drawn.items()}
    own = own_lines(known, found, np.random.default_rng(seed))
    return Draws(values=found | {"own": own}, divergences=int(np.asarray(diverging).sum()))


def own_lines(known: Sums, drawn: Mapping[str, Array], rng: np.random.Generator) -> Array:
    """Draw each participant's intercept and exponent, given draws of the other parameters."""
    mean = np.stack([drawn["A"], drawn["B"]], axis=-1)[..., None, :]
    r = 2 * drawn["half_r"] - 1
    factor = np.zeros((*r.shape, 1, 2, 2))
    factor[..., 0, 0, 0] = drawn["ta"]
    factor[..., 0, 1, 0] = drawn["tb"] * r
    factor[..., 0, 1, 1] = drawn["tb"] * np.sqrt(1 - r**2)
    variance = (drawn["s"] ** 2)[..., None]
    inner = np.eye(2) + factor.swapaxes(-1, -2) @ known.xx @ factor / variance[..., None, None]
    rest = known.xy - (known.xx @ mean[..., None])[..., 0]
    pulled = (factor.swapaxes(-1, -2) @ rest[..., None]) / variance[..., None, None]
    centre = mean + (factor @ np.linalg.solve(inner, pulled))[..., 0]
    # inner is U U', so U'⁻¹ z has the inverse of inner as covariance; factor then scales it.
    noise = rng.standard_normal((*centre.shape, 1))
    upper = np.linalg.cholesky(inner).swapaxes(-1, -2)
    return np.asarray(centre + (factor @ np.linalg.solve(upper, noise))[..., 0])
