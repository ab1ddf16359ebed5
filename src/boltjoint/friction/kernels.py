"""Forces of the elements of any law in compiled loops: each law brings its kernel.

A law keeps the arrays of its elements in a named tuple of its own, and has for it a compiled
function that ``implements`` the one here.
"""


def add_forces(elements, motion, force, tangent):  # noqa: ANN001, ANN201
    """Add the forces of all elements, and the tangents where their array is not empty.

    Parameters
    ----------
    elements
        The named tuple of a law.
    motion
        As for ``FrictionLaw.force``, shape (points, directions * components).
    force, tangent
        As from ``FrictionLaw.force_and_tangent``.
    """
    raise NotImplementedError
