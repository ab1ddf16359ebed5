"""Modes that a structure from another program has in place of stiffness and mass."""

from boltjoint.config.entries import Entry
from boltjoint.config.types import MatrixFile, Problems, VariableName

#: ends of names of universal files
UNIVERSAL = (".unv", ".uff")
#: what they hold of nodes, by the same names
_OF_NODES = ("mode_shape", "node", "node_position")


class MatrixModes(Entry):
    """Modes in place of stiffness and mass: of a modal test, or a modal reduction.

    Degrees of freedom are those of ``mode_shape``: sides, rows and loads are given as of matrices.
    Without ``mode_shape`` they are the modal coordinates, so that ``relative`` and ``row`` hold the
    modes there. Contact acts on these modes alone: what others would add has to be among them.
    """

    file: MatrixFile | None = None
    """File of these variables; by default as for all others. A universal file, ``.unv`` or
    ``.uff``, has ``natural_frequency``, ``mode_shape``, ``node`` and ``damping_ratio`` of normal
    modes (data sets 55), and ``node_position`` (15 or 2411); its shapes are scaled to unit modal
    mass by the modal mass that it gives. It needs ``boltjoint[uff]``."""
    natural_frequency: VariableName = "natural_frequency"
    """Variable of the natural frequencies in Hz, 0 of rigid-body modes, (modes)."""
    mode_shape: VariableName | None = None
    """Variable of the modes with unit modal mass, (degrees of freedom, modes); of a universal file
    its own."""
    damping_ratio: VariableName | None = None
    """Variable of their viscous damping ratios, (modes): of cases that give neither ``loss_factor``
    nor ``damping``."""
    node: VariableName | None = None
    """Variable of the numbers of the nodes, whose x, y, z are rows of ``mode_shape`` one after
    another, (nodes). Then ``side_a`` and ``side_b`` are numbers of nodes, (points), and inputs and
    outputs may name a ``node``. Of a universal file its own."""
    node_position: VariableName | None = None
    """Variable of the positions of these nodes, (nodes, 3): contact points lie between their two
    nodes. By default ``contact.position``; of a universal file its own."""

    @property
    def is_universal(self) -> bool:
        """Whether they are those of a universal file."""
        return self.file is not None and self.file.endswith(UNIVERSAL)

    def variable(self, key: str) -> str | None:
        """Variable of a key, which a universal file may have by itself."""
        given: str | None = getattr(self, key)
        return key if given is None and self.is_universal and key in _OF_NODES else given

    def conflicts(self) -> Problems:
        if self.variable("node_position") is not None and self.variable("node") is None:
            yield ("node_position",), "must not be given without node"
        if self.variable("node") is not None and self.variable("mode_shape") is None:
            yield ("node",), "must not be given without mode_shape"
