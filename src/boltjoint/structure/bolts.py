"""Strain of the bolt shanks under preload, beside the strain at which bolts yield.

The model is linear, so it accepts any preload; a preload beyond yield gives a warning.
"""

#: property class 8.8 of ISO 898-1, 640 MPa, over the Young's modulus of steel, 206 GPa; only a
#: warning depends on it
YIELD_STRAIN = 640e6 / 206e9


def shank_strain(preload: float, area: float, youngs_modulus: float) -> float:
    """Strain of a shank of uniform tension, ``N / (E A)``.

    Parameters
    ----------
    preload
        N, tension of the bolt [N].
    area
        A, cross-section of the shank [m2].
    youngs_modulus
        E [Pa].
    """
    return preload / (youngs_modulus * area)


def yield_warning(preload: float, area: float, youngs_modulus: float) -> str | None:
    """A sentence where the shanks are strained beyond yield; None where they are not.

    Parameters
    ----------
    preload, area, youngs_modulus
        As for ``shank_strain``.
    """
    strain = shank_strain(preload, area, youngs_modulus)
    if strain <= YIELD_STRAIN:
        return None
    return (
        f"a preload of {preload:g} N strains the shanks by {strain:.2%}, more than the "
        f"{YIELD_STRAIN:.2%} at which steel bolts of class 8.8 yield; the model stays elastic"
    )
