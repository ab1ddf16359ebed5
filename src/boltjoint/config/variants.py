"""Variants of a sweep: its base case under each combination of keys that need another joint."""

from collections.abc import Callable, Mapping
from hashlib import blake2b
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.config.assembly import Assembly
from boltjoint.config.case import Case
from boltjoint.config.sweep import Sweep
from boltjoint.config.types import Problems
from boltjoint.config.varied_case import refused, with_all_ratios, with_values
from boltjoint.config.varied_keys import (
    ASSEMBLY,
    JOINT,
    is_rescaled,
    key_of,
    path_of,
    with_numbers,
    with_value_at,
)
from boltjoint.names import JointName

#: characters of a name beyond which values are told by a hash: folders have 255
_LONGEST_NAME = 120


class Variant(NamedTuple):
    """A base case, its assembly and its joint with other values of some keys.

    ``values`` are these; ``case_name`` and ``assembly_name`` tell the files; ``reason`` why it is
    impossible, empty where it is not.
    """

    values: Mapping[str, float]
    case_name: str
    assembly_name: str
    case: Case
    assembly: Assembly
    joint: JointName
    reason: str = ""


Conflicts = Callable[[Sweep, Case, Assembly], Problems]
"""What an assembly and the settings do not allow in a case, solved as a sweep does."""


def find_variants(
    sweep: Sweep,
    case: Case,
    assembly: Assembly,
    columns: Mapping[str, NDArray[np.float64]],
    conflicts: Conflicts,
) -> list[Variant]:
    """The variants of a sweep, in the order of its designs.

    Parameters
    ----------
    sweep
        The sweep.
    case, assembly
        The base case and its assembly.
    columns
        Values of the keys by design.
    conflicts
        As ``Conflicts``.
    """
    keys = [key for key in columns if not is_rescaled(key)]
    if not keys:
        return [Variant({}, sweep.case, case.assembly, case, assembly, sweep.joint)]
    rows = np.column_stack([columns[key] for key in keys])
    distinct = dict.fromkeys(map(tuple, rows.tolist()))
    return [
        _variant(sweep, case, assembly, dict(zip(keys, row, strict=True)), conflicts)
        for row in distinct
    ]


def _variant(
    sweep: Sweep,
    case: Case,
    assembly: Assembly,
    values: dict[str, float],
    conflicts: Conflicts,
) -> Variant:
    """A variant, as far as it is possible."""
    of_assembly, of_joint = (
        {key.removeprefix(part): value for key, value in values.items() if key.startswith(part)}
        for part in (ASSEMBLY, JOINT)
    )
    of_case = {key: value for key, value in values.items() if not key.startswith(JOINT)}
    name, reasons, joint = case.assembly, [], sweep.joint
    content = assembly.model_dump()
    for key, value in of_assembly.items():
        content = with_value_at(content, path_of(key), value)
    if found := refused(content, Assembly):
        reasons += [f"{ASSEMBLY}{reason}" for reason in found]
    elif content != assembly.model_dump():
        assembly, name = Assembly.model_validate(content), _named(name, of_assembly)
    content = with_all_ratios(case.model_dump(), of_case, len(assembly.bolt_positions_mm))
    content = with_values(content, of_case)
    content["verification_forces_N"] = case.verification_forces_N
    reasons += refused(content, Case)
    try:
        joint = with_numbers(joint, of_joint)
    except ValueError as error:
        reasons.append(f"{JOINT}{error}")
    if not reasons:
        case = Case.model_validate(content)
        alone = sweep.model_copy(update={"joint": joint})
        reasons += [f"{key_of(path)}: {line}" for path, line in conflicts(alone, case, assembly)]
    case = case.model_copy(update={"assembly": name})
    told = "; ".join(reasons)
    return Variant(values, _named(sweep.case, of_case), name, case, assembly, joint, told)


def _named(name: str, values: Mapping[str, float]) -> str:
    """The name of a file or folder, with values."""
    if not values:
        return name
    told = [f"{'.'.join(map(str, path_of(key)))}={value:.15g}" for key, value in values.items()]
    full = ",".join([name, *told])
    if len(full) <= _LONGEST_NAME:
        return full
    return f"{name},{blake2b(full.encode(), digest_size=8).hexdigest()}"
