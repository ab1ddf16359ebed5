"""Decks of tests: public ones beside the checkout where they are, and small ones as text."""

from pathlib import Path

import pytest

#: decks of others that are kept here, and others that may lie beside the checkout
KEPT = Path(__file__).with_name("public_decks")
BESIDE = next(
    (each / "shared/decks" for each in Path(__file__).parents if (each / "shared/decks").is_dir()),
    None,
)
NOT_KEPT = "not_for_the_repository"

#: two cubes of the side 1, one upon the other, that share no node
TWO_CUBES = """*HEADING
two cubes
*NODE, NSET=ALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
11, 0., 0., 1.
12, 1., 0., 1.
13, 1., 1., 1.
14, 0., 1., 1.
15, 0., 0., 2.
16, 1., 0., 2.
17, 1., 1., 2.
18, 0., 1., 2.
*ELEMENT, TYPE=C3D8, ELSET=LOWER
1, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=C3D8, ELSET=UPPER
2, 11, 12, 13, 14, 15, 16, 17, 18
*SURFACE, NAME=TOP OF LOWER
LOWER, S2
*SURFACE, NAME=BOTTOM OF UPPER
2, S1
*MATERIAL, NAME=STEEL
*ELASTIC
210000., 0.3
*DENSITY
7.85E-9
*SOLID SECTION, ELSET=LOWER, MATERIAL=STEEL
*SOLID SECTION, ELSET=UPPER, MATERIAL=STEEL
"""


def public(name):
    """File of a public deck, as seen from their folder; the test is left out where it is not."""
    folder = next((each for each in (KEPT, BESIDE) if each and (each / name).is_file()), None)
    if folder is None:
        pytest.skip(f"{name} is not beside this checkout")
    return folder, name
