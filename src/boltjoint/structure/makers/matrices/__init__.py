"""Structures from stiffness and mass matrices, or modes, of other programs."""

from pathlib import Path
from typing import TYPE_CHECKING

from boltjoint.config.described import MeshSize
from boltjoint.config.matrices import Matrices as Description

if TYPE_CHECKING:
    from boltjoint.structure.model import Structure

__all__ = ["PAGE", "Description", "check", "damping_ratios_of", "make", "size_of"]


#: module that tells pages of them
PAGE = f"{__name__}.model_check"


def make(description: Description, folder: Path) -> "Structure":
    """The structure."""
    from boltjoint.structure.makers.matrices.structure import structure_of_matrices

    return structure_of_matrices(description, folder)


def size_of(description: Description, folder: Path) -> MeshSize:
    """Size of the structure; as many nodes as have all degrees of freedom."""
    from boltjoint.structure.makers.matrices.source import sizes_of_matrices

    sizes = sizes_of_matrices(description, folder)
    return MeshSize(nodes=-(-sizes.dofs // 3), elements=0, pairs=sizes.points)


def damping_ratios_of(description: Description, folder: Path) -> tuple[float, ...]:
    """Viscous damping ratios of its elastic modes, where files hold them."""
    from boltjoint.structure.makers.matrices.modal_data import damping_ratios

    return damping_ratios(description, folder)


def check(description: Description, folder: Path) -> tuple[dict[str, str], list[str]]:
    """What files describe, by words, and what to look at before anything is solved."""
    from boltjoint.structure.makers.matrices.model_check import check_of

    return check_of(description, folder)
