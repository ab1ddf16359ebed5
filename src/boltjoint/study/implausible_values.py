"""Values that no bolted joint has, as they are in another unit: told in a line, not refused."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from boltjoint.config.case import Case
from boltjoint.config.described import Described
from boltjoint.config.study import Study
from boltjoint.config.types import ASSEMBLY_FOLDER, CASE_FOLDER
from boltjoint.number_format import number


class Plausible(NamedTuple):
    """Range of a value, and what one below and one above may be, or one a million times smaller."""

    lowest: float
    highest: float
    below: str = ""
    above: str = ""
    far_below: str = ""


_STIFFNESS = Plausible(1e4, 1e12, "is this in N/mm or kN/mm?", "is this per area?")
_PER_AREA = Plausible(1e9, 1e17, "is this in N/mm³?", "")

#: by the name of a key, wherever it stands
RANGES = {
    "youngs_modulus_GPa": Plausible(0.5, 1000, "is this in TPa?", "is this in MPa?"),
    "density_kg_per_m3": Plausible(200, 25e3, "is this in g/cm³?", far_below="is this in t/mm³?"),
    "preload_N": Plausible(100, 1e7, "is this in kN?", ""),
    "friction_coefficient": Plausible(0.01, 1.5, "", "is this in percent?"),
    "tangential_stiffness_N_per_m": _STIFFNESS,
    "normal_stiffness_N_per_m": _STIFFNESS,
    "tangential_stiffness_N_per_m3": _PER_AREA,
    "normal_stiffness_N_per_m3": _PER_AREA,
    "penalty_N_per_m3": _PER_AREA,
    "loss_factor": Plausible(0, 0.3, "", "is this in percent?"),
    "forces_N": Plausible(0, 1e4, "", ""),
    "element_length_free_mm": Plausible(0.1, 50, "is this in m?", "is this coarse on purpose?"),
    "shank_diameter_mm": Plausible(1, 200, "is this in m?", ""),
}


def implausible(study: Study) -> Iterator[str]:
    """A line for each value of the cases and assemblies that no bolted joint has."""
    used = {case.assembly for case in study.cases.values()} | set(study.assemblies)
    described: dict[str, Described | Case] = {
        f"{ASSEMBLY_FOLDER}/{name}.yaml": study.assembly(name) for name in sorted(used)
    }
    described |= {f"{CASE_FOLDER}/{name}.yaml": case for name, case in study.cases.items()}
    for file, entry in described.items():
        for path, value in _numbers(entry.model_dump()):
            if told := _doubt(path.rpartition(".")[2].partition("[")[0], value):
                yield f"{file}: {path}: {told}"


def _numbers(content: Any, path: str = "") -> Iterator[tuple[str, float]]:  # noqa: ANN401
    """All numbers with their key paths."""
    if isinstance(content, Mapping):
        for key, value in content.items():
            yield from _numbers(value, f"{path}.{key}" if path else str(key))
    elif isinstance(content, list | tuple):
        for place, value in enumerate(content):
            yield from _numbers(value, f"{path}[{place}]")
    elif isinstance(content, int | float) and not isinstance(content, bool):
        yield path, float(content)


#: of the lowest plausible value: what is below is in a unit of another kind
_FAR_BELOW = 1e-6


def _doubt(key: str, value: float) -> str:
    """What is said of a value; nothing where it is plausible."""
    if key not in RANGES:
        return ""
    lowest, highest, below, above, far_below = RANGES[key]
    if lowest <= value <= highest:
        return ""
    guess = below if value < lowest else above
    if value < _FAR_BELOW * lowest:
        guess = far_below or guess
    usual = f"{number(lowest)} to {number(highest)}"
    return f"{number(value)} is unusual for a bolted joint ({usual}){guess and ': ' + guess}"
