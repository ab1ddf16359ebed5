"""Modes of a test in a universal file: normal modes at nodes, and where the nodes are.

Data sets 55 have six digits. Their displacements are in axes of space, and scaled to unit modal
mass by the modal mass of each mode.

References
----------
Structural Dynamics Research Laboratory, University of Cincinnati: Universal file formats for modal
analysis testing, data sets 15, 55, 164 and 2411.
"""

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boltjoint.regular_file import UnsuitableFile
from boltjoint.structure.contact_points import DIRECTIONS
from boltjoint.structure.makers.matrices.variables import (
    Size,
    UnsuitableVariable,
    dense_size,
)

Array = NDArray[np.float64]

_MODES, _NODES, _UNITS = 55, (15, 2411), 164
_NORMAL_MODE, _MARK = 2, "-1"
_TO_A_METRE = {"m": 1.0, "mm": 1e3}
#: numbers of the coordinate system of space
_OF_SPACE = (0, 1)


class UniversalFile:
    """``natural_frequency`` [Hz] and ``damping_ratio``, (modes,), in ascending order.

    ``mode_shape`` (3 * nodes, modes), ``node`` (nodes,) and ``node_position`` (nodes, 3) of all
    nodes that a mode has, in ascending order; what a mode does not hold of a node is zero.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def require_units(self, length_unit: str) -> None:
        """Refuse another unit than m with N, or mm with N, where data set 164 tells it.

        Raises
        ------
        UnsuitableFile
            If it is another one.
        """
        for units in self._of_kind(_UNITS):
            found = float(units["length"]), float(units["force"])
            if not np.allclose(found, (_TO_A_METRE[length_unit], 1.0), rtol=1e-6):
                sentence = "has {:g} of its lengths in a metre and {:g} of its forces in a newton"
                expected = f"with length_unit: {length_unit} it must have "
                expected += f"{_TO_A_METRE[length_unit]:g} and 1"
                raise UnsuitableFile(self._path, f"{sentence.format(*found)}: {expected}")

    def names(self) -> list[str]:
        with_nodes = ["node_position"] if self._of_kind(*_NODES) else []
        return sorted(["damping_ratio", "mode_shape", "natural_frequency", "node", *with_nodes])

    def size(self, name: str) -> Size:
        return dense_size(self.read(name).shape)

    def read(self, name: str) -> Array:
        found: Array = getattr(self, f"_{name}")
        return found

    @cached_property
    def _sets(self) -> list[dict[str, Any]]:
        try:
            import pyuff
        except ImportError:
            sentence = "needs pyuff: pip install boltjoint[uff]"
            raise UnsuitableFile(self._path, sentence) from None
        with open(self._path, encoding="ascii", errors="replace") as lines:
            # one before and one after each data set
            if sum(line.strip() == _MARK for line in lines) % 2:
                raise UnsuitableFile(self._path, "ends within a data set")
        try:
            file = pyuff.UFF(str(self._path))
            # others are not read, whatever they are
            places = np.flatnonzero(np.isin(file.get_set_types(), [_MODES, *_NODES, _UNITS]))
            return [file.read_sets(int(place)) for place in places]
        # pyuff raises errors of any kind where a file is damaged
        except Exception as error:
            sentence = f"cannot be read as a universal file: {' '.join(str(error).split())}"
            raise UnsuitableFile(self._path, sentence) from None

    def _of_kind(self, *kinds: int) -> list[dict[str, Any]]:
        return [each for each in self._sets if each["type"] in kinds]

    @cached_property
    def _modes(self) -> list[dict[str, Any]]:
        """Data sets of the modes."""
        sets = self._of_kind(_MODES)
        if not sets:
            raise UnsuitableVariable("is not there: the file has no data set 55")
        for number, mode in enumerate(sets, 1):
            if mode["analysis_type"] != _NORMAL_MODE:
                kind = mode["analysis_type"]
                raise UnsuitableVariable(
                    f"is of analysis type {kind} in data set 55 number {number}: it must be that "
                    "of normal modes, 2"
                )
        return sorted(sets, key=lambda mode: mode["freq"])

    @cached_property
    def _natural_frequency(self) -> Array:
        return self._values("freq")

    @cached_property
    def _damping_ratio(self) -> Array:
        return self._values("modal_damp_vis")

    @cached_property
    def _node(self) -> Array:
        return np.unique(np.concatenate([_numbers(mode["node_nums"]) for mode in self._modes]))

    @cached_property
    def _mode_shape(self) -> Array:
        node = self._node
        shape = np.zeros((len(node), DIRECTIONS, len(self._modes)))
        mass = self._values("modal_m")
        for number, mode in enumerate(self._modes):
            # not a number is not above 0 either
            if not mass[number] > 0:
                raise UnsuitableVariable(
                    f"has no modal mass in the mode of {mode['freq']:g} Hz: it is {mass[number]:g}"
                )
            own = _numbers(mode["node_nums"])
            if len(np.unique(own)) < len(own):
                raise UnsuitableVariable(f"has a node twice in the mode of {mode['freq']:g} Hz")
            place = np.searchsorted(node, own)
            for direction, key in enumerate(("r1", "r2", "r3")):
                values = np.asarray(mode.get(key, np.zeros(len(own))))
                if np.any(np.imag(values) != 0):
                    raise UnsuitableVariable(
                        f"is complex in the mode of {mode['freq']:g} Hz: it must be real"
                    )
                shape[place, direction, number] = np.real(values)
        return shape.reshape(-1, len(mass)) / np.sqrt(mass)

    @cached_property
    def _node_position(self) -> Array:
        sets, node = self._of_kind(*_NODES), self._node
        number = np.concatenate([_numbers(each["node_nums"]) for each in sets])
        position = np.concatenate(
            [np.column_stack([each[axis] for axis in "xyz"]) for each in sets]
        )
        order = np.argsort(number, kind="stable")
        place = order[np.minimum(np.searchsorted(number, node, sorter=order), number.size - 1)]
        if (missing := node[number[place] != node]).size:
            raise UnsuitableVariable(
                f"lacks node {missing[0]:g}, which modes have: data sets 15 or 2411 must hold it"
            )
        for key in ("def_cs", "disp_cs"):
            system = np.concatenate([_numbers(each[key]) for each in sets])[place]
            if (own := np.flatnonzero(~np.isin(system, _OF_SPACE))).size:
                raise UnsuitableVariable(
                    f"is in coordinate system {system[own[0]]:g} at node {node[own[0]]:g}: it must "
                    "be that of space, 0 or 1"
                )
        return position[place]

    def _values(self, key: str) -> Array:
        return np.array([float(mode[key]) for mode in self._modes])


def _numbers(values: Sequence[float]) -> Array:
    return np.asarray(values, dtype=float).ravel()
