"""Initial gap of the contact pairs: where the surfaces of the bars stand apart as they touch.

The form error of both surfaces together is a field that is known up to a constant, since the bars
approach each other until they touch: the smallest gap is 0.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks

if TYPE_CHECKING:
    from boltjoint.config.assembly import Assembly
    from boltjoint.config.gap_map import GapMap

Array = NDArray[np.float64]

_MM, _UM = 1e-3, 1e-6


def initial_gap(
    assembly: "Assembly", position: Array, gap_map: "GapMap | None" = None
) -> Array | None:
    """Initial gap of contact pairs [m], shape (pairs,); None where surfaces are flat.

    With L and W the length and the width of the lap, and x, y from its centre::

        g = -h (x^2 + y^2) / ((L/2)^2 + (W/2)^2) + w cos(2 pi x / lambda) - smallest

    h is the flatness, the distance of two parallel planes that the paraboloid lies between over
    the lap, w the amplitude of the waviness and lambda its wavelength; or g is that of the map.

    Parameters
    ----------
    assembly
        Dimensions, and ``contact.gap_um``.
    position
        Positions of the pairs, shape (pairs, 3) [m].
    gap_map
        The map where ``contact.gap_um`` is the name of a file.

    Raises
    ------
    ValueError
        If the map is missing, does not cover the lap or is not symmetric about its middle.
    """
    check_described(assembly)
    position = checks.array("position", position, ("pairs", 3))
    form, lap, width = assembly.contact.gap_um, assembly.bar.lap_mm, assembly.bar.width_mm
    if form is None:
        return None
    # To a picometre, and on one side: the same bytes on both, which preload and joint rely on.
    x = np.round(position[:, 0] / _MM - assembly.bar.free_length_mm[0] - lap / 2, 9)
    y = np.round(abs(position[:, 1]) / _MM, 9)
    if isinstance(form, str):
        if gap_map is None:
            raise ValueError(f"gap_map is None: contact.gap_um needs the map in {form}")
        for sentence in gap_map.conflicts(lap, width):
            raise ValueError(f"gap_map {sentence}")
        field = (gap_map.at(x, y) + gap_map.at(x, -y)) / 2
    else:
        field = -form.flatness_um * (x**2 + y**2) / ((lap / 2) ** 2 + (width / 2) ** 2)
        if form.wavelength_mm is not None:
            field += form.waviness_um * np.cos(2 * np.pi * x / form.wavelength_mm)
    return _UM * (field - field.min())


def check_described(assembly: "Assembly") -> None:
    """Refuse what is no description of an assembly."""
    # imported here: jobs that only read an assembly do without
    from boltjoint.config.assembly import Assembly

    checks.instance("assembly", assembly, Assembly)
