"""Two tubes with flanges and a bolt circle."""

from pathlib import Path
from typing import TYPE_CHECKING

from boltjoint.config.flange import Flange as Description

if TYPE_CHECKING:
    from boltjoint.structure.model import Structure

__all__ = ["PAGE", "Description", "make"]


#: module that tells pages of them
PAGE = f"{__name__}.facts"


def make(description: Description, folder: Path) -> "Structure":
    """The structure."""
    from boltjoint.structure.extrusion.bodies import structure_of_bodies
    from boltjoint.structure.makers.flange.mesh import mesh_of

    return structure_of_bodies(description, mesh_of(description))
