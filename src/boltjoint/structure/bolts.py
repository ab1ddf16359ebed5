"""Strain of the bolt shanks under preload, against the yield strain.

The model is linear, so it accepts any preload; a preload beyond yield gives a warning.
"""

#: property class 8.8 of ISO 898-1, 640 MPa, over the Young's modulus of steel, 206 GPa; only a
#: warning depends on it
YIELD_STRAIN = 640e6 / 206e9


def yield_warning(preload: float, area: float, youngs_modulus: float) -> str | None:
    """A sentence where shanks of uniform tension yield, ``N / (E A) > YIELD_STRAIN``, or None.

    Parameters
    ----------
    preload
        N, tension of the bolt [N].
    area
        A, cross-section of the shank [m2].
    youngs_modulus
        E [Pa].
    """
    strain = preload / (youngs_modulus * area)
    if strain <= YIELD_STRAIN:
        return None
    return (
        f"a preload of {preload:g} N strains the shanks by {strain:.2%}, more than the "
        f"{YIELD_STRAIN:.2%} at which steel bolts of class 8.8 yield; the model stays elastic"
    )
