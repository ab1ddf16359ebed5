"""Files of a study with one thing changed at a time."""

import copy
import random
from pathlib import Path

from pydantic import ValidationError

from boltjoint.config.numerical_options import Settings
from boltjoint.config.strict_yaml import parse_mapping

ROOT = Path(__file__).parents[2]

#: of every kind, and on both sides of every limit that the models have
VALUES = [
    None,
    True,
    "",
    "word",
    "5",
    [],
    [1],
    [1, 1.0],
    {},
    {"word": 1},
    -1,
    0,
    1e-30,
    1e-9,
    0.019999,
    0.02,
    0.499999,
    0.5,
    0.999999,
    1,
    1.0,
    1.000001,
    2,
    3,
    7,
    8,
    12.0,
    12.5,
    99,
    300,
    300.0,
    301,
    5e3,
    10**20,
    1e30,
    "x",
    "y",
    "up",
    "constant",
    "variable",
    "mean",
    "analytic",
    "aft",
    "lagged",
    "linear",
    "none",
    "overview",
    "structure",
    "three_bolt",
    "three bolt",
    "../three_bolt",
    "bölt",
    64 * "a",
    65 * "a",
    "free-0",
    "free-01",
    "free-1",
    "free-2",
    "free-9",
    "free-10",
    "free-300",
    "free-301",
    "free-1000",
    "enriched-2",
    "enriched",
    "rdnm-0",
    "rdnm-1",
    "rdnm-300",
    "rdnm-301",
    "complex-rdnm-2",
    "backbone",
    "Linear",
    "node-to-node",
    "regions=0",
    "regions=1",
    "regions=999999",
    "regions=1000000",
    "regions=auto",
    "regions=2/table",
    "clusters=2/elements=0",
    "clusters=2/elements=999999",
    "clusters=2/harmonic=1000000",
    "clusters=2/loops=1",
    "clusters",
]


#: of the shipped study
FILES = {
    "config": "config.yaml",
    "assembly": "assemblies/three_bolt.yaml",
    "washers": "assemblies/three_bolt_aluminium.yaml",
    "constant": "cases/three_bolt_constant.yaml",
    "variable": "cases/three_bolt_variable.yaml",
}
#: entries of a list that are changed; those after them are like them
ENTRIES = 3


def whole_files():
    """Content of files with all keys, by the names of ``FILES``."""
    contents = {
        name: parse_mapping((ROOT / "config" / file).read_text(encoding="utf-8"))
        for name, file in FILES.items()
    }
    text = (ROOT / "config/convergence.yaml").read_text(encoding="utf-8")
    defaults = Settings(cases=["three_bolt"]).model_dump(mode="json")
    contents["config"] = defaults | contents["config"] | parse_mapping(text)
    contents["config"] |= {"assemblies": ["three_bolt", "four_bolt"]}
    bolts, mesh = (contents["washers"][section] for section in ("bolts", "mesh"))
    bolts["washer"] |= {"under": ["head", "nut"], "material": dict(bolts["material"])}
    mesh |= {"rings_head_to_washer_edge": 2, "layers_in_washer": 1}
    point = {"x_mm": 100, "y_mm": 0, "z_mm": 10, "direction": "z"}
    force = point | {"relative_amplitude": 0.5, "phase_deg": 90.0}
    contents["constant"] |= {
        "excitation": {"kind": "forces", "points": [force]},
        "sensors": [point | {"name": "lap"}, point | {"name": "tip", "x_mm": 400}],
    }
    contents["variable"]["excitation"] = {"kind": "distributed", "surface": "top", "direction": "z"}
    contact = contents["variable"]["contact"]
    contact["normal_stiffness_N_per_m3"] = 1e6 * contact.pop("normal_stiffness_N_per_m")
    contents["variable"]["regions"] |= {"motion": "mean", "tolerance": 0.02}
    contents["variable"]["solve"][0] |= {
        "modes": ["free-4"],
        "coordinates": ["linear"],
        "window_Hz": [50, 100.5],
    }
    return contents


def mutations(content):
    """Content with one change, and the key path of the change, for every key and kind of change."""
    yield {**content, "word": 1}, ("word",)
    for *above, last in _places(content):
        for change in (_other_values, _other_size, _other_key):
            for changed in change(_at(content, above)[last], last):
                mutated = copy.deepcopy(content)
                holder = _at(mutated, above)
                del holder[last]
                if isinstance(holder, list):
                    holder[last:last] = changed.values()
                else:
                    holder |= changed
                yield mutated, (*above, last)


def samples(content, model, number=2):
    """Some of the mutations of each key: key path, content, and what the model says of it.

    That is ``allowed``, ``contradiction`` for keys that contradict each other, ``refused`` for keys
    alone; there are up to ``number`` samples of each key and kind of error.
    """
    found = {}
    for changed, path in mutations(content):
        kinds = kinds_of_error(model, changed)
        found.setdefault((path, *kinds), []).append(changed)
    chance = random.Random(0)
    for (path, *kinds), contents in found.items():
        verdict = "refused" if kinds else "allowed"
        if set(kinds) == {"contradiction"}:
            verdict = "contradiction"
        for changed in chance.sample(contents, min(number, len(contents))):
            yield path, changed, verdict


def kinds_of_error(model, content):
    """The types of the errors that pydantic raises; none if the content is allowed."""
    try:
        model.model_validate(content)
    except ValidationError as error:
        return sorted(problem["type"] for problem in error.errors(include_url=False))
    return []


def _other_values(value, key):
    for other in VALUES:
        yield {key: other}
    if isinstance(value, int | float) and not isinstance(value, bool):
        for factor in (-1, 0.5, 1.5, 10):
            yield {key: factor * value}


def _other_size(value, key):
    yield {}
    if isinstance(value, list):
        yield {key: value[:1]}
        yield {key: [*value, *value[:1]]}
        yield {key: [*value, "word"]}
    elif isinstance(value, dict):
        yield {key: value | {"word": 1}}


def _other_key(value, key):
    if isinstance(key, str):
        for other in (f"{key}s", key.upper(), f" {key}", f"{key[:1]}é{key[1:]}"):
            yield {other: value}


def _places(value, path=()):
    """The key path of every value within a value."""
    inner = value.items() if isinstance(value, dict) else list(enumerate(value))[:ENTRIES]
    for part, each in inner:
        yield (*path, part)
        if isinstance(each, dict | list):
            yield from _places(each, (*path, part))


def _at(content, path):
    for part in path:
        content = content[part]
    return content
