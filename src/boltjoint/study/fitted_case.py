"""The fitted case as YAML: a case with the values that were fitted to its measurement."""

from collections.abc import Mapping
from textwrap import wrap
from typing import Any

import xarray as xr
import yaml

from boltjoint.config.varied_keys import path_of, value_at, with_value_at

#: characters of a line of words
_WIDTH = 96
#: keys of a case that its file may leave out
_WITH_DEFAULT = "loss_factor", "preload_N"


def fitted_case(name: str, content: Mapping[str, Any], calibration: xr.Dataset) -> str:
    """The file of a case, with fitted values in place of those before.

    Parameters
    ----------
    name
        Name of the case before.
    content
        What its file says.
    calibration
        ``calibration.nc``.

    Returns
    -------
    str
        YAML. The answer stands above in comments, with the values of parameters that are no keys of
        a case: ratios of frequencies, of regions and of amplitudes.
    """
    changed = {key: value for key, value in content.items() if key != "measured"}
    further = []
    for key, value, is_determined in zip(
        map(str, calibration["parameter"].to_numpy()),
        map(float, calibration["value"].to_numpy()),
        map(bool, calibration["is_determined"].to_numpy()),
        strict=True,
    ):
        if key in _WITH_DEFAULT or _has(changed, key):
            changed = with_value_at(_with_parent(changed, key), path_of(key), _rounded(value))
            note = "" if is_determined else f"{key} is not told by the measurement."
        else:
            note = f"{key} = {value:.6g} is no key of a case: it is not in this file."
        further += [note] if note else []
    texts = [f"{name}, fitted to its measurement.", calibration.attrs["answer"], *further]
    head = "".join(f"# {line}\n" for text in texts for line in wrap(text, _WIDTH))
    return f"{head}\n{yaml.safe_dump(_plain(changed), sort_keys=False, allow_unicode=True)}"


def _has(content: Mapping[str, Any], key: str) -> bool:
    try:
        value_at(content, path_of(key))
    except (LookupError, TypeError):
        return False
    return True


def _with_parent(content: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """The content with a key that its file left out."""
    return content if _has(content, key) else {**content, key: 0.0}


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")


def _plain(content: Any) -> Any:  # noqa: ANN401
    """The content as YAML has it."""
    if isinstance(content, Mapping):
        return {str(key): _plain(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [_plain(value) for value in content]
    return str(content) if isinstance(content, str) else content
