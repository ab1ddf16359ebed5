"""Time of a calibration, from the sizes of its joint and its measurement alone."""

from boltjoint.calibration.bolt_preloads import LEVELS
from boltjoint.calibration.fit_preloads import REPETITIONS
from boltjoint.config.conflicts_of_measured import fits_preloads
from boltjoint.config.measured import Measured

#: of a measured point in each evaluation of a fit, and for each element, vector and parameter [s];
#: evaluations from one start
_PER_POINT, _PER_DERIVATIVE, _EVALUATIONS = 2e-4, 4e-8, 30
#: evaluations for the profile of a parameter, and for posterior draws with those that find them
_OF_PROFILE, _DRAWN = 16, 300
#: posterior draws of which curves are predicted
_PREDICTED = 200


def time_of_calibration(measured: Measured, effort: float, fitted: int, predicted: int) -> float:
    """Time of a fit and its predictions, without that of tightening bolts [s].

    Parameters
    ----------
    measured
        What is fitted, and from how many starts.
    effort
        Relative time of the law times the number of elements and of vectors.
    fitted, predicted
        Numbers of points.
    """
    count = len(measured.parameters)
    # derivatives by each parameter take two residuals
    of_point = _PER_POINT + _PER_DERIVATIVE * effort * (1 + count)
    # the profile of each parameter, and draws that need no derivatives
    fits = measured.starts * (1 + (1 + REPETITIONS) * fits_preloads(measured))
    evaluations = _EVALUATIONS * fits + _OF_PROFILE * count + _DRAWN / (1 + count)
    of_predicted = (_PER_POINT + _PER_DERIVATIVE * effort) * _PREDICTED
    return of_point * evaluations * fitted + of_predicted * predicted


def count_tightenings(measured: Measured, bolts: int) -> int:
    """How often contact is solved where preloads of bolts are fitted.

    For each bolt at each level, around each start and around the results of its repeated fits.
    """
    return measured.starts * (1 + REPETITIONS) * bolts * len(LEVELS)
