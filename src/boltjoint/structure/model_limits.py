"""Limits of the model of a structure: what leaves it at a peak, and when it does not hold there."""

from typing import NamedTuple

#: share of its length by which a structure may move in a linear model: the tip of a cantilever that
#: is deflected by a tenth of its length moves back by 0.6 % of it, which is left out
LINEAR = 0.1


class Limit(NamedTuple):
    """A limit of the model, and what is compared with it.

    Attributes
    ----------
    name
        ``peak_<name>`` is the share of the limit that is reached at a peak.
    modes
        Variable of modes, (place, component, mode): what is compared is the length of the vector
        of components.
    limit
        Variable of the limit of each place, or of all.
    tolerated
        Share beyond which the model does not hold.
    meaning
        Of the share.
    problem
        In a sentence, after the force, with shares reached and tolerated in percent.
    is_proportional
        Whether shares grow with the amplitude at the output point, but for changes of the shape.
    """

    name: str
    modes: str
    limit: str
    tolerated: float
    meaning: str
    problem: str
    is_proportional: bool = True

    def told(self, share: float) -> str:
        """The problem with the share that is reached; empty within what is tolerated."""
        if not share > self.tolerated:
            return ""
        return self.problem % (100 * share, 100 * self.tolerated)


DISPLACEMENT = Limit(
    "displacement_over_length",
    "farthest_mode",
    "structure_length",
    LINEAR,
    "largest displacement at the peak over the length of the structure",
    "the structure moves by %.0f %% of its length at the peak, which a linear model does not hold: "
    "beyond %.0f %% peaks are those of small displacements",
)
SLIP = Limit(
    "slip_over_clearance",
    "hole_mode",
    "hole_clearance",
    1.0,
    "largest slip at a bolt at the peak over the clearance of its hole",
    "bodies slip at a bolt by %.0f %% of the clearance of its hole at the peak: beyond %.0f %% the "
    "shank bears on the hole, which the model leaves out",
    # nothing slips at small amplitudes
    is_proportional=False,
)
STRESS = Limit(
    "stress_over_strength",
    "stress_mode",
    "yield_strength",
    1.0,
    "largest nominal stress of the motion at the peak over the yield strength",
    "the nominal stress reaches %.0f %% of the yield strength at the peak: beyond %.0f %% parts "
    "yield, which the model leaves out",
)
LIMITS = (DISPLACEMENT, SLIP, STRESS)
