"""Keys that a sweep may vary: of the contact, the case, its assembly and its joint, by their paths.

With other values of some keys a joint is rescaled, in each design anew. All other keys ask for
another mesh, tightening or reduction.
"""

import difflib
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from boltjoint.config.case import Case
from boltjoint.config.described import Described
from boltjoint.config.units import unit_of, without_unit
from boltjoint.names import JointName

#: where a key of the assembly, of the preload of a bolt and of the joint begins
ASSEMBLY, RATIOS, JOINT = "assembly.", "preload_ratios[", "joint."
#: what else of a case may vary though it needs another joint
_OF_CASE = ("excitation", "sensors", "regions")


class Quantity(NamedTuple):
    """What a key that varies is called in results, its unit and its meaning.

    ``factor`` makes that unit of a value of the key.
    """

    name: str
    unit: str
    meaning: str
    factor: float = 1.0


def rescaled_keys(case: Case) -> dict[str, Quantity]:
    """The keys that need no other joint than that of the base case, rescaled."""
    level, unit = ("accelerations_m_per_s2", "m/s2") if case.is_base_excited else ("forces_N", "N")
    quantities = {
        "preload_N": Quantity("preload", "N", "preload of each bolt"),
        level: Quantity("force_level", unit, "excitation amplitude"),
    }
    if case.damping is None:
        quantities["loss_factor"] = Quantity("loss_factor", "1", "structural loss factor")
    else:
        quantities |= _quantities("damping.", case.damping.model_dump(exclude={"model"}))
    for quantity in case.contact.quantities:
        sentence = _as_meaning(quantity.meaning)
        quantities[f"contact.{quantity.key}"] = Quantity(quantity.name, quantity.unit, sentence)
    for number, surface in enumerate(case.contact.surfaces):
        for quantity in surface.quantities:
            sentence = f"{_as_meaning(quantity.meaning)} of surface {surface.name}"
            name = f"surface_{number}_{quantity.name}"
            key = f"contact.surfaces[{number}].{quantity.key}"
            quantities[key] = Quantity(name, quantity.unit, sentence)
    return quantities


def keys_that_vary(case: Case, assembly: Described | None, joint: JointName) -> dict[str, Quantity]:
    """All keys that may vary: those that are rescaled first.

    Parameters
    ----------
    case
        The base case.
    assembly
        Its assembly; None if that cannot be read.
    joint
        The joint that is solved.
    """
    quantities = rescaled_keys(case)
    for part, _ in _parts(joint):
        sentence = f"number of {part}" if part != "hyper" else "number of weighted pairs"
        quantities[f"{JOINT}{part}"] = Quantity(f"joint_{part}", "1", sentence)
    if assembly is not None:
        bolts = assembly.bolt_count
        for n in range(bolts):
            meaning = f"preload of bolt {n + 1} over that of all"
            quantities[f"{RATIOS}{n}]"] = Quantity(f"preload_ratio_{n}", "1", meaning)
        of_assembly = _quantities(ASSEMBLY, assembly.model_dump(exclude={"preload_N"}))
        quantities |= {
            key: quantity
            for key, quantity in of_assembly.items()
            if path_of(key)[-1] not in assembly.NAMING_KEYS
        }
    quantities |= _quantities("", case.model_dump(include=set(_OF_CASE)))
    return quantities


def is_rescaled(key: str) -> bool:
    """Whether a key that varies needs no other joint, as ``rescaled_keys``."""
    return not key.startswith((ASSEMBLY, RATIOS, JOINT, *_OF_CASE))


def not_varied(key: str, keys: Collection[str]) -> str:
    """What is said of a key that is none that may vary."""
    close = difflib.get_close_matches(key, keys, n=1)
    meant = f"; did you mean {close[0]}?" if close else ";"
    short = ", ".join(shown for shown in keys if is_rescaled(shown) or shown.startswith(JOINT))
    return (
        f"is no key that varies{meant} there are: {short}, and other numbers of the case and its "
        "assembly by their paths, as preload_ratios[0] or assembly.bar.lap_mm"
    )


def path_of(key: str) -> tuple[str | int, ...]:
    """The path of a key, as ``forces_N[0]`` or ``bar.lap_mm``.

    >>> path_of("sensors[0].x_mm")
    ('sensors', 0, 'x_mm')
    """
    parts = re.findall(r"[^.\[\]]+", key)
    return tuple(int(part) if part.isdigit() else part for part in parts)


def key_of(path: Sequence[str | int]) -> str:
    """The key at a path, as ``path_of`` reads it.

    >>> key_of(("sensors", 0, "x_mm"))
    'sensors[0].x_mm'
    """
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return "".join(parts).removeprefix(".")


def value_at(content: Any, path: Sequence[str | int]) -> float:  # noqa: ANN401
    """The number at a path of a content."""
    for part in path:
        content = content[part]
    return content


def with_value_at(content: Any, path: Sequence[str | int], value: float) -> Any:  # noqa: ANN401
    """The content with another number at a path, whole where the one before was."""
    if not path:
        whole = isinstance(content, int) and float(value).is_integer()
        return int(value) if whole else value
    first, *rest = path
    changed: Any = dict(content) if isinstance(content, Mapping) else list(content)
    inner = content.get(first) if isinstance(content, Mapping) else content[first]
    changed[first] = with_value_at(inner, rest, value)
    return changed if isinstance(changed, dict) else tuple(changed)


def with_numbers(joint: JointName, values: Mapping[str, float]) -> JointName:
    """The joint with other numbers of its parts; a ``ValueError`` if they are not whole.

    >>> with_numbers(JointName("regions=6/elements=7"), {"elements": 3.0})
    'regions=6/elements=3'
    """
    name = str(joint)
    for part, value in values.items():
        if value < 1 or not float(value).is_integer():
            raise ValueError(f"{part}: {value:g} must be a whole number of at least 1")
        name = re.sub(rf"\b{part}=\w+", f"{part}={value:.0f}", name)
    return JointName(name)


def _parts(joint: JointName) -> list[tuple[str, str]]:
    """Parts of a joint, with their numbers."""
    return re.findall(r"(\w+)=(\w+)", joint)


def _quantities(before: str, content: object) -> dict[str, Quantity]:
    """The numbers of an entry by their keys."""
    quantities = {}
    for path in _paths_of_numbers(content):
        last = next(part for part in reversed(path) if isinstance(part, str))
        unit = unit_of(last)
        words = [without_unit(part) if isinstance(part, str) else str(part) for part in path]
        meaning = " ".join(words).replace("_", " ")
        quantities[before + key_of(path)] = Quantity("_".join(words), unit.si, meaning, unit.factor)
    return quantities


def _paths_of_numbers(content: object) -> Iterator[tuple[str | int, ...]]:
    """Paths of all numbers of a content."""
    if isinstance(content, Mapping):
        items: Iterable[tuple[Any, Any]] = content.items()
    elif isinstance(content, list | tuple):
        items = enumerate(content)
    else:
        if isinstance(content, int | float) and not isinstance(content, bool):
            yield ()
        return
    for part, inner in items:
        yield from ((part, *path) for path in _paths_of_numbers(inner))


def _as_meaning(sentence: str) -> str:
    return sentence[0].lower() + sentence[1:].partition(". ")[0].rstrip(".")
