"""Posterior draws by an ensemble of walkers, for posteriors that no importance draws stand for.

References
----------
J. Goodman, J. Weare: Ensemble samplers with affine invariance. Communications in Applied
Mathematics and Computational Science 5 (2010) 65-80.
D. Foreman-Mackey, D. W. Hogg, D. Lang, J. Goodman: emcee: the MCMC hammer. Publications of the
Astronomical Society of the Pacific 125 (2013) 306-312.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: walkers for each parameter, and at least
_WALKERS, _FEWEST = 4, 16
#: share of the steps that lead to the posterior, and are left out
_LEFT_OUT = 0.5
#: spread of the walkers at the begin, over the standard errors, and over the bounds at most
_BEGUN, _WIDEST = 0.5, 0.05


@dataclass(frozen=True)
class EnsembleDraws:
    """Draws of parameters in their scales, which depend on those before them.

    Attributes
    ----------
    scaled
        All draws after those that are left out, (draws, parameters).
    effective
        Number of independent ones, by the longest autocorrelation: some hundred are needed.
    steps
        Of a walker, over that autocorrelation: below 50 it is not well known, and is too short.
    accepted
        Share of steps that were accepted: 0.2 to 0.5 where walkers move well.
    """

    scaled: Array
    effective: float
    steps: float
    accepted: float


def ensemble_draws(
    cost: Callable[[Array], float],
    centre: Array,
    deviation: Array,
    bounds: tuple[Array, Array],
    count: int,
    seed: int,
) -> EnsembleDraws:
    """Draws of exp(-cost) within bounds.

    Parameters
    ----------
    cost
        Half the sum of squares; a ``ValueError`` where the model has no mode.
    centre, deviation
        Around which the walkers begin, each (parameters,).
    bounds
        Beyond which the posterior is zero.
    count, seed
        Of the draws.

    Raises
    ------
    ValueError
        If emcee is not installed.
    """
    try:
        import emcee
    except ImportError:
        raise ValueError("walkers need emcee: pip install boltjoint[mcmc]") from None
    low, high = bounds
    random = np.random.default_rng(seed)

    def log_density(at: Array) -> float:
        if np.any(at < low) or np.any(at > high):
            return -np.inf
        try:
            return -cost(at)
        except ValueError:
            return -np.inf

    walkers = max(_WALKERS * centre.size, _FEWEST)
    spread = np.minimum(_BEGUN * deviation, _WIDEST * (high - low))
    begun: list[Array] = []
    while len(begun) < walkers:
        at = np.clip(centre + spread * random.standard_normal(centre.size), low, high)
        # halved where nothing can be solved so far away
        if np.isfinite(log_density(at)):
            begun.append(at)
        else:
            spread = spread / 2
    sampler = emcee.EnsembleSampler(walkers, centre.size, log_density)
    state = np.random.RandomState(seed).get_state()
    steps = int(np.ceil(count / walkers / (1 - _LEFT_OUT)))
    sampler.run_mcmc(emcee.State(np.array(begun), random_state=state), steps)
    left_out = steps - int(np.ceil(count / walkers))
    chain = sampler.get_chain(discard=left_out)
    time = max(float(np.max(emcee.autocorr.integrated_time(chain, quiet=True, tol=0))), 1.0)
    drawn = chain.reshape(-1, centre.size)[-count:]
    accepted = float(np.mean(sampler.acceptance_fraction))
    return EnsembleDraws(drawn, len(drawn) / time, len(chain) / time, accepted)
