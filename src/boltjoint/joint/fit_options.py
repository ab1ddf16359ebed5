"""Numerical options of the elements that are fitted to those of a region."""

from dataclasses import dataclass

from boltjoint import checks
from boltjoint.options import Options


@dataclass(frozen=True)
class FitOptions(Options):
    """What of the hysteresis is compared in fits of a few elements, or of one Iwan element.

    Half or twice of any of them moves the peaks of the joints ``elements=7``, ``harmonic=7`` and
    ``iwan`` of the default study (``free-4``, three and four bolts, 1, 10 and 50 N) by at most 3e-4
    in frequency and 4e-3 in amplitude: several fits are about equally good.

    Parameters
    ----------
    loop_samples
        Points along half a loop at which forces are compared, evenly in phase.
    compared_amplitudes
        Amplitudes up to full slip at which describing functions, and loops for their mean error,
        are compared, evenly in their logarithm.
    curve_samples
        Displacements at which the loading curve of an Iwan element, which has no corners, is
        compared beside the corners of that of the region. Only the errors that are stated depend on
        it.
    lowest_amplitude
        Smallest amplitude at which describing functions are compared, over that of the first slip:
        a fit must not slip before the region.
    loss_weight
        Weight of relative errors of small losses, against errors of force over the slip force;
        times the square of the number of elements, with whose inverse errors of force fall.
    hidden_loss
        Loss, over the total stiffness, below which the structure's own damping hides that of the
        contact, as light structural damping does.
    sharpnesses
        Sharpness of the minimax loading curves from which the fit of describing functions starts:
        the smaller, the more weight small amplitudes have.

    Raises
    ------
    ValueError
        If one of them is not positive, a number of samples is not whole, or there is no sharpness.
    """

    loop_samples: int = 64
    compared_amplitudes: int = 120
    curve_samples: int = 400
    lowest_amplitude: float = 0.8
    loss_weight: float = 0.0023
    hidden_loss: float = 1e-3
    sharpnesses: tuple[float, ...] = (8.0, 16.0, 32.0, 128.0)

    def __post_init__(self) -> None:
        """Refuse options with which nothing can be compared."""
        for name in ("loop_samples", "compared_amplitudes", "curve_samples"):
            checks.whole(name, getattr(self, name), at_least=2)
        for name in ("lowest_amplitude", "loss_weight", "hidden_loss"):
            checks.number(name, getattr(self, name), above=0)
        checks.numbers("sharpnesses", self.sharpnesses)
