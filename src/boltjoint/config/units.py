"""Units of keys, which are the ends of their names."""

from typing import NamedTuple


class Unit(NamedTuple):
    """A unit as it is written, and in SI units: its name and factor."""

    written: str
    si: str
    factor: float = 1.0


#: by the end of a key; of two ends the longer one comes first
_UNITS = {
    "N_per_m3": Unit("N/m³", "N/m3"),
    "kg_per_m3": Unit("kg/m³", "kg/m3"),
    "N_s_per_m3": Unit("N s/m³", "N s/m3"),
    "N_s_per_m": Unit("N s/m", "N s/m"),
    "N_per_m": Unit("N/m", "N/m"),
    "1_per_s": Unit("1/s", "1/s"),
    "m_per_s2": Unit("m/s²", "m/s2"),
    "deg": Unit("°", "degree"),
    "mm": Unit("mm", "m", 1e-3),
    "um": Unit("μm", "m", 1e-6),
    "percent": Unit("%", "1", 1e-2),
    "GPa": Unit("GPa", "Pa", 1e9),
    "MPa": Unit("MPa", "Pa", 1e6),
    "Hz": Unit("Hz", "Hz"),
    "N": Unit("N", "N"),
    "s": Unit("s", "s"),
}
_NUMBER = Unit("1", "1")

#: units of measured motion, as they end the names of columns, and their factors to SI
MOTION_UNITS = {
    "displacement": {"m": 1.0, "mm": 1e-3, "um": 1e-6},
    "velocity": {"m_per_s": 1.0, "mm_per_s": 1e-3},
    "acceleration": {"m_per_s2": 1.0, "mm_per_s2": 1e-3, "g": 9.80665},
}


def unit_of(key: str) -> Unit:
    """The unit of a number under a key."""
    return next((unit for end, unit in _UNITS.items() if key.endswith(f"_{end}")), _NUMBER)


def without_unit(key: str) -> str:
    """The key without its unit."""
    end = next((end for end in _UNITS if key.endswith(f"_{end}")), None)
    return key if end is None else key.removesuffix(f"_{end}")
