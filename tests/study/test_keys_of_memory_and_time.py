"""Every numeric key of a configuration is asked of the estimate, or it is said why it need not be.

The schemas of the four kinds of files are walked. A key counts as seen if a much larger or a much
smaller number of it, or a list of many numbers, needs more memory or time.
"""

import copy
import re
from functools import cache

import pytest
from small_study import ASSEMBLY, CASE, SETTINGS, write

from boltjoint.config.reference import SCHEMAS
from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError
from boltjoint.study import memory_and_time_of_study as needs

FILES = {
    "config": "config/config.yaml",
    "assembly": "config/assemblies/two_bolt.yaml",
    "case": "config/cases/small.yaml",
    "sweep": "config/sweeps/swept.yaml",
}
#: a study in which each part of the estimate has its share
CONTENTS = {
    "config": SETTINGS
    | {
        "sweeps": ["swept"],
        "solver": {"friction_force": "aft", "harmonics": 1, "time_samples": 256},
    },
    "assembly": ASSEMBLY,
    "case": CASE | {"coordinates": ["linear"], "solve": CASE["solve"][:1], "modes": ["enriched-8"]},
    "sweep": {
        "case": "small",
        "vary": {
            "loss_factor": {"kind": "linear", "lowest": 0.001, "highest": 0.002, "number": 3},
            "preload_N": [9000, 10000],
        },
        "levels": [20],
        "design": {"kind": "grid"},
        "basis": "free-2",
        "joint": "regions=3/elements=2",
        "observe": ["peaks", "responses", "contact-states", "backbone"],
    },
}
_MANY = [20, *(round(1 + n * 1e-3, 6) for n in range(3000))]
_WASHERS = {
    "bolts": ASSEMBLY["bolts"] | {"washer": {"thickness_mm": 2, "diameter_mm": 18}},
    "mesh": ASSEMBLY["mesh"] | {"layers_in_washer": 1, "rings_head_to_washer_edge": 1},
}
_LATIN_HYPERCUBE = {"kind": "latin-hypercube", "number": 64}
_ROW = {"number": 2, "pitch_mm": 30}
#: other contents of files in which a key has its place
PLACES = {
    ("assembly", "bolts.number"): {
        "assembly": {
            "bolts": {key: ASSEMBLY["bolts"][key] for key in list(ASSEMBLY["bolts"])[1:]} | _ROW,
            "bar": ASSEMBLY["bar"] | {"lap_mm": 20000},
        }
    },
    ("assembly", "mesh.layers_in_washer"): {"assembly": _WASHERS},
    ("case", "measured.starts"): {
        "case": {
            "measured": {
                "curves": [
                    {
                        "file": "config/backbone.csv",
                        "resonance": 1,
                        "frequency_error_percent": 0.1,
                        "damping_error_percent": 5,
                    }
                ],
                "parameters": {"loss_factor": {"low": 1e-4, "high": 0.1}},
            }
        }
    },
    ("case", "verification_forces_N[]"): {
        "case": {"forces_N": _MANY, "modes": ["free-2"]},
        "config": {"solver": {}},
    },
    ("config", "convergence.time_integration_N[]"): {
        "case": {"forces_N": _MANY},
        "config": {"solver": {}},
    },
    ("config", "solver.harmonics"): {
        "config": {"solver": {"friction_force": "aft", "time_samples": 10**4}}
    },
    ("sweep", "converged_designs"): {
        "sweep": {
            "design": _LATIN_HYPERCUBE | {"number": 10**5},
            "observe": ["peaks", "converged-peaks"],
            "converged_designs": 30,
        }
    },
    ("sweep", "converged_designs[].number"): {
        "sweep": {
            "design": _LATIN_HYPERCUBE | {"number": 10**5},
            "observe": ["peaks", "converged-peaks"],
            "converged_designs": [{"harmonics": 33, "number": 30}],
        }
    },
    ("sweep", "check.designs"): {
        "sweep": {"design": _LATIN_HYPERCUBE | {"number": 10**5}, "check": {"basis": "free-2"}}
    },
    ("sweep", "design.number"): {"sweep": {"design": _LATIN_HYPERCUBE}},
}

_OF_MOTION = "amplitudes of a motion that is solved in any case"
_BOUNDED = "its number is at most that of the vectors, pairs or regions, which is counted"
_OF_MATERIAL = "a quantity of the equations, which are as many"
_FIXED = "a list of a given length"
#: keys that multiply neither memory nor time, by the beginning of their paths, and why
WITHOUT = {
    "config": {
        "contact_adapted_basis.amplitude_tolerance": _BOUNDED,
        "contact_adapted_basis.balanced_vectors": _BOUNDED,
        "contact_adapted_basis.free_modes": "at most 299, beside two for each of the pairs",
        "contact_adapted_basis.frequency_tolerance": _BOUNDED,
        "contact_adapted_basis.highest_amplitude": _OF_MOTION,
        "contact_adapted_basis.lowest_amplitude": _OF_MOTION,
        "contact_adapted_basis.maximum_vectors": "bases have as many as they are called after",
        "contact_adapted_basis.pattern_tolerance": _BOUNDED,
        "contact_adapted_basis.resonances": "at most free_modes",
        "contact_adapted_basis.smallest_growth": _OF_MOTION,
        "contact_adapted_basis.trial_step": "at most as many trials as vectors",
        "fitting.load_fractions": _FIXED,
        "hyper_reduction": _BOUNDED,
        "solver.harmonic_tolerance": "at most 33 harmonics, which are counted",
        "solver.largest_error": "a limit of warnings",
        "solver.maximum_iterations": "at most 100, met where a step fails",
        "solver.maximum_solutions": "an upper limit: as many are found as the steps ask for",
        "solver.smallest_step": "met where a branch ends",
        "solver.target_iterations": "less than maximum_iterations",
        "solver.tolerance": "two iterations more or less",
    },
    "assembly": {
        "bar.height_mm": _OF_MATERIAL,
        "bar.width_mm": _OF_MATERIAL,
        "bar.lap_mm": "divided into as many elements",
        "bolts.head_diameter_mm": _OF_MATERIAL,
        "bolts.head_height_mm": _OF_MATERIAL,
        "bolts.hole_diameter_mm": _OF_MATERIAL,
        "bolts.material": _OF_MATERIAL,
        "bolts.nut_height_mm": _OF_MATERIAL,
        "bolts.pitch_mm": _OF_MATERIAL,
        "bolts.positions_from_lap_start_mm": "bolts that fit into the lap: see bolts.number",
        "bolts.shank_diameter_mm": _OF_MATERIAL,
        "bolts.washer": _OF_MATERIAL,
        "contact": _OF_MATERIAL,
        "material": _OF_MATERIAL,
        "mesh.bolt_cell_length_mm": "divided into as many elements",
        "mesh.rings_head_to_washer_edge": "some of the rings from the head to the edge of the cell",
        "preload_N": _OF_MATERIAL,
    },
    "matrices": {"": "sizes are those of the files, which are counted"},
    "deck": {"": "sizes are those of the files, which are counted"},
    "plates": {"": "sizes are those of the mesh: tests/structure/test_plates.py counts it"},
    "flange": {"": "sizes are those of the mesh: tests/structure/test_flange.py counts it"},
    "case": {
        "accelerations_m_per_s2": "as forces_N, with another excitation",
        "bolt_preloads_N": "as many as bolts",
        "contact": _OF_MATERIAL,
        "damping": _OF_MATERIAL,
        "excitation": "a vector of the modes, whatever the number of points",
        "loss_factor": _OF_MATERIAL,
        "measured.curves": "points of their files, which are counted",
        "measured.predicted": "the same",
        "measured.responses": "the same",
        "measured.parameters": _OF_MATERIAL,
        "measured.seed": "the number of the random numbers that are drawn",
        "preload_N": _OF_MATERIAL,
        "preload_ratios": "as many as bolts",
        "regions.tolerance": "at most 64 regions",
        "sensors": "a vector of the modes each",
        "solve[].resonance": "one of the modes that are found",
        "solve[].window_Hz": "steps are parts of the window",
    },
    "sweep": {
        "amplitudes_mm": _FIXED,
        "harmonics": "at most 33 are tried, which are counted",
        "check.harmonics": "at most 33 are tried, which are counted",
        "converged_designs[].harmonics": "at most 33 are tried, which are counted",
        "designs_per_job": "the job that gathers all designs holds more",
        "check.seed": "the number of the random numbers that are drawn",
        "design.seed": "the number of the random numbers that are drawn",
        "resonance": "one of the modes that are found",
        "vary{}.coefficient_of_variation": _OF_MATERIAL,
        "vary{}.highest": _OF_MATERIAL,
        "vary{}.likeliest": _OF_MATERIAL,
        "vary{}.lowest": _OF_MATERIAL,
        "vary{}.mean": _OF_MATERIAL,
        "vary{}.standard_deviation": _OF_MATERIAL,
    },
}
_LARGE = 10**9


def numeric_keys(schema, node=None, path=""):
    """Paths of all numbers with their limits.

    ``[]`` is each value of a list, ``()`` the first of a list of given length, ``{}`` that of any
    key.
    """
    node = schema if node is None else node
    if "$ref" in node:
        yield from numeric_keys(schema, schema["$defs"][node["$ref"].split("/")[-1]], path)
    if node.get("type") in ("integer", "number"):
        yield path, node
    for one in ("anyOf", "oneOf", "allOf", "prefixItems"):
        for inner in node.get(one, ()):
            yield from numeric_keys(schema, inner, path + ("()" if one == "prefixItems" else ""))
    if isinstance(node.get("items"), dict):
        yield from numeric_keys(schema, node["items"], f"{path}[]")
    if isinstance(node.get("additionalProperties"), dict):
        yield from numeric_keys(schema, node["additionalProperties"], path + "{}")
    for key, inner in node.get("properties", {}).items():
        yield from numeric_keys(schema, inner, f"{path}.{key}".removeprefix("."))


KEYS = sorted(
    {
        (file, path): limits
        for file, model in SCHEMAS.items()
        for path, limits in numeric_keys(model.model_json_schema())
    }.items(),
    key=lambda item: item[0],
)


def reason(file, path):
    """Why a key needs not be asked for; None if nothing is said of it."""
    found = (why for start, why in WITHOUT[file].items() if path.startswith(start))
    return next(found, None)


def with_value(content, path, value):
    """The content with a value at a path."""
    content = copy.deepcopy(content)
    *parts, last = re.findall(r"\w+|\[\]|\(\)|\{\}", path)
    place = content
    for part, after in zip(parts, [*parts, last][1:], strict=True):
        if part in ("[]", "()"):
            place = place[0]
        elif part == "{}":
            place = place["preload_N" if after == "[]" else "loss_factor"]
        else:
            place = place.setdefault(part, {})
    if last == "[]":
        place[:] = value
    else:
        place[0 if last == "()" else last] = value
    return content


def values_to_try(path, limits):
    """Large and small numbers within the limits, or a list of many."""
    if path.endswith("[]"):
        return [_MANY, list(range(1, 70))]
    multiple = limits.get("multipleOf", 1)
    large = min(limits.get("maximum", _LARGE), 0.999 * limits.get("exclusiveMaximum", 2 * _LARGE))
    if limits["type"] == "integer":
        numbers = (int(large), 2**20, 200, 20, limits.get("minimum", 1))
        return [number // multiple * multiple for number in numbers]
    return [float(large), max(limits.get("minimum", 1e-6), 1e-6)]


def estimated(folder, contents):
    """Memory and time of a study of these files."""
    for name, content in contents.items():
        write(folder / FILES[name], content)
    found = needs.estimate(load_study(folder))
    return found.memory, found.seconds


@pytest.fixture(scope="module")
def is_seen(tmp_path_factory):
    """Whether the estimate grows by half with another number of a key."""
    folder = tmp_path_factory.mktemp("study")
    (folder / "config").mkdir()
    rows = [f"{0.01 * (1 + n)},340,0.01" for n in range(500)]
    table = "\n".join(["displacement_mm,frequency_Hz,damping_ratio", *rows])
    (folder / "config/backbone.csv").write_text(f"{table}\n", encoding="utf-8")

    def contents_of(place):
        changes = PLACES.get(place, {})
        return {file: content | changes.get(file, {}) for file, content in CONTENTS.items()}

    # of a key without a place of its own it is always the same
    unchanged = cache(lambda place: estimated(folder, contents_of(place)))

    def ask(file, path, limits):
        place = (file, path) if (file, path) in PLACES else None
        contents, before = contents_of(place), unchanged(place)
        for value in values_to_try(path, limits):
            try:
                changed = with_value(contents[file], path, value)
                after = estimated(folder, contents | {file: changed})
            except (ConfigError, KeyError, TypeError, IndexError):
                # of another kind, or with which the rest of the study does not go
                continue
            if any(new > 1.5 * old for new, old in zip(after, before, strict=True)):
                return True
        return False

    return ask


@pytest.mark.parametrize(("which", "limits"), KEYS, ids=[":".join(which) for which, _ in KEYS])
def test_a_key_is_in_the_estimate_or_needs_not_be(is_seen, which, limits):
    needless = reason(*which) is not None
    # a reason that is none is one of a key that multiplies memory or time
    assert is_seen(*which, limits) != needless, which


def test_reasons_are_of_keys_that_there_are():
    known = {file: [path for (of, path), _ in KEYS if of == file] for file in SCHEMAS}
    for file, reasons in WITHOUT.items():
        for start in reasons:
            assert any(path.startswith(start) for path in known[file]), (file, start)
