"""A small study of files of every kind, and random changes of one of them at a time.

Values are of any type and magnitude, in YAML under any key and in CSV in any cell; lines of a text
are cut, repeated and strewn with characters. Every change follows from its seed.
"""

import copy
import io
import json
import random
import re
import string
from contextlib import suppress

import numpy as np
import yaml
from decks import TWO_CUBES
from small_study import ASSEMBLY, CASE, SETTINGS, SWEEP, VARIABLE

DISTRIBUTIONS = {
    "loss_factor": {"kind": "triangular", "lowest": 0.001, "likeliest": 0.002, "highest": 0.004},
    "contact.friction_coefficient": {
        "kind": "lognormal",
        "mean": 0.1,
        "coefficient_of_variation": 0.2,
    },
    "contact.tangential_stiffness_N_per_m": {"kind": "log", "lowest": 1e8, "highest": 1e9},
    "contact.normal_stiffness_N_per_m": {"kind": "normal", "mean": 1e8, "standard_deviation": 1e6},
    "assembly.bar.lap_mm": [62, 64.0],
    "joint.regions": [2, 3],
}
SAMPLES = {
    "case": "shaped",
    "vary": DISTRIBUTIONS,
    "levels": [5, 20],
    "design": {"kind": "latin-hypercube", "number": 20, "seed": 1},
    "basis": "free-2",
    "joint": "regions=3",
    "amplitudes_mm": [0.01, 1],
    "observe": ["peaks", "backbone"],
}
FORCE = {"x_mm": 100, "y_mm": 0, "z_mm": 10, "direction": "z"}
POINTS = {
    "excitation": {"kind": "forces", "points": [FORCE | {"phase_deg": 90.0}]},
    "sensors": [FORCE | {"name": "lap"}],
}
BOLTS = ASSEMBLY["bolts"] | {
    "material": dict(ASSEMBLY["material"]),
    "washer": {"thickness_mm": 2, "diameter_mm": 15, "under": ["head"]},
}
GAP = {"flatness_um": 5, "waviness_um": 1, "wavelength_mm": 60}

PLATES = {
    "type": "plates",
    "plates": {
        "width_mm": 70,
        "thickness_mm": [5, 6],
        "free_length_mm": [50, 60],
        "lap_mm": 90,
    },
    "pattern": {"rows": 3, "columns": 2, "pitch_mm": 20, "gauge_mm": 36, "staggered": True},
    "material": dict(ASSEMBLY["material"]),
    "bolts": {key: BOLTS[key] for key in list(BOLTS)[1:]},
    "mesh": {"element_length_mm": 10, "layers": [1, 2]},
    "points": [{"name": "tip", "near_mm": [200, 0, 6], "direction": "z"}],
    "symmetry": "xz",
    "preload_N": 1000,
}

FLANGE = {key: PLATES[key] for key in ("material", "bolts", "mesh", "symmetry", "preload_N")} | {
    "type": "flange",
    "tubes": {"inner_diameter_mm": 30, "outer_diameter_mm": 40, "length_mm": [90, 80]},
    "flange": {"outer_diameter_mm": 90, "thickness_mm": [8, 9]},
    "bolt_circle": {"diameter_mm": 64, "number": 4, "first_angle_deg": 45},
    "points": [{"name": "tip", "near_mm": [20, 0, 89], "direction": "x"}],
}

DECK = {
    "type": "deck",
    "file": "config/cubes.inp",
    "units": {"length": "mm", "mass": "t"},
    "elements": [{"kind": "C3D8", "read_as": "C3D8I"}],
    "contact": [{"name": "lap", "surfaces": ["TOP OF LOWER", "BOTTOM OF UPPER"]}],
    "points": [{"name": "tip", "near_mm": [1, 1, 2], "direction": "z"}],
    "bolts": [{"name": "bolt", "plane": {"point_mm": [3, 0, 1], "normal": [0, 0, 1]}}],
    "preload_N": 1000,
}
#: a shank of two elements beside the cubes
SHANK = """*NODE
21, 3., 0., 0.
22, 4., 0., 0.
23, 4., 1., 0.
24, 3., 1., 0.
25, 3., 0., 1.
26, 4., 0., 1.
27, 4., 1., 1.
28, 3., 1., 1.
29, 3., 0., 2.
30, 4., 0., 2.
31, 4., 1., 2.
32, 3., 1., 2.
*ELEMENT, TYPE=C3D8, ELSET=SHANK
3, 21, 22, 23, 24, 25, 26, 27, 28
4, 25, 26, 27, 28, 29, 30, 31, 32
*SOLID SECTION, ELSET=SHANK, MATERIAL=STEEL
"""
#: modes of a joint of two contact points, as another program writes them
MODAL = {
    "natural_frequency": np.array([90.0, 300.0]),
    "relative": np.arange(12.0).reshape(6, 2),
    "tip": np.array([1.0, -1.0]),
    "area": np.full(2, 1e-4),
    "position": np.array([[0.0, 0, 0], [0.01, 0, 0]]),
    "normal_load": np.array([100.0, 200.0]),
}
MATRICES = {
    "type": "matrices",
    "file": "config/modal.npz",
    "modes": {},
    "contact": {"relative": "relative", "normal_load": "normal_load", "preload_N": 300},
    "inputs": [{"name": "shaker", "row": "tip", "direction": "z"}],
    "outputs": [{"name": "sensor", "row": "tip", "direction": "z"}],
}
MEASURED = {
    "curves": [
        {
            "file": "config/bar.csv",
            "resonance": 1,
            "frequency_error_percent": 0.02,
            "damping_error_percent": 1,
        }
    ],
    "parameters": {
        "contact.friction_coefficient": {
            "low": 0.05,
            "high": 0.5,
            "prior": {"mean": 0.2, "standard_deviation": 0.3},
        },
        "loss_factor": {"low": 1e-4, "high": 0.05, "log": False, "start": 0.01},
    },
}

#: content of the YAML files, by kind
CONTENTS = {
    "config": {
        "config/config.yaml": SETTINGS
        | {
            "cases": ["small", "shaped", "measured"],
            "sweeps": ["grid", "samples", "table"],
            "assemblies": ["two_bolt", "mapped", "plates", "flange", "deck", "matrices"],
            "omit": ["timing"],
            "solver": {"friction_force": "aft", "harmonics": 3, "time_samples": 64},
            "hyper_reduction": {"frequency_tolerance": 0.001},
        }
    },
    "assembly": {
        "config/assemblies/two_bolt.yaml": ASSEMBLY,
        "config/assemblies/mapped.yaml": ASSEMBLY
        | {"contact": {"gap_um": "config/map.csv"}, "preload_N": 1000, "bolts": BOLTS},
        "config/assemblies/shaped.yaml": ASSEMBLY | {"contact": {"gap_um": GAP}},
        "config/assemblies/plates.yaml": PLATES,
        "config/assemblies/flange.yaml": FLANGE,
        "config/assemblies/deck.yaml": DECK,
        "config/assemblies/matrices.yaml": MATRICES,
    },
    "case": {
        "config/cases/small.yaml": CASE | POINTS | {"solve": CASE["solve"][:2]},
        "config/cases/shaped.yaml": VARIABLE
        | {"assembly": "shaped", "preload_ratios": [1, 0.5], "regions": {"motion": "mean"}},
        "config/cases/measured.yaml": CASE | {"measured": MEASURED, "solve": CASE["solve"][:2]},
    },
    "sweep": {
        "config/sweeps/grid.yaml": SWEEP,
        "config/sweeps/samples.yaml": SAMPLES,
        "config/sweeps/table.yaml": {
            "case": "small",
            "design": {"kind": "table", "file": "config/designs.csv"},
            "basis": "free-2",
            "joint": "regions=3/elements=2",
        },
    },
}
#: text of all files, by kind
TEXTS = {
    kind: {file: yaml.safe_dump(content) for file, content in contents.items()}
    for kind, contents in CONTENTS.items()
} | {
    "table of designs": {
        "config/designs.csv": "preload_N,contact.friction_coefficient,assembly.bar.lap_mm\n"
        "10000,0.1,62\n12000,0.2,62\n11000,0.15,64\n"
    },
    "map of a gap": {
        "config/map.csv": "x_mm,y_mm,gap_um\n"
        + "".join(f"{x},{y},{x * x / 100}\n" for x in (-40, 0, 40) for y in (-10, 0, 10))
    },
    "measured curve": {
        "config/bar.csv": "displacement_mm,frequency_Hz,damping_ratio\n"
        "0.001,340.0,0.002\n0.01,338.0,0.004\n0.1,335.0,0.006\n"
    },
    "deck": {"config/cubes.inp": TWO_CUBES + SHANK},
}
KINDS = tuple(TEXTS)

#: words that mean something somewhere
WORDS = sorted(
    set(re.findall(r"[\w./=-]+", " ".join(json.dumps(each) for each in CONTENTS.values())))
)
#: characters that mean something in YAML and CSV, in a file name or on a screen
ODD = "\n\r\t\0\x1b\u2028\ufeff\ud7ffé😀١,;:\"'#&*!|>%@`{}[]()-~.=/\\<$ \xa0"


def write_study(folder):
    """Write all files."""
    (folder / "config").mkdir(parents=True, exist_ok=True)
    (folder / "config/modal.npz").write_bytes(modal_data())
    for texts in TEXTS.values():
        for file, text in texts.items():
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            (folder / file).write_text(text, encoding="utf-8")


def modal_data():
    """The content of the file of modal data."""
    content = io.BytesIO()
    np.savez(content, **MODAL)
    return content.getvalue()


def content_of(file):
    """The content of a YAML file."""
    return next(contents[file] for contents in CONTENTS.values() if file in contents)


def mutation(seed, kind):
    """A file of a kind and its text with random changes."""
    chance = random.Random(f"{kind} {seed}")
    file = chance.choice(list(TEXTS[kind]))
    if kind in CONTENTS and chance.random() < 0.7:
        return file, _dumped(_changed(CONTENTS[kind][file], chance), chance)
    if file.endswith(".csv") and chance.random() < 0.6:
        return file, _other_cells(TEXTS[kind][file], chance)
    return file, _strewn(TEXTS[kind][file], chance)


def _changed(content, chance):
    """The content with other values, or without or with keys, in one to three places."""
    content = copy.deepcopy(content)
    for _ in range(chance.choice([1, 1, 1, 2, 3])):
        places = list(_places(content))
        if not places:
            break
        holder, key = chance.choice(places)
        numbers = [(h, k) for h, k in places if type(h[k]) in (int, float)] or [(holder, key)]
        match chance.choice(4 * ["number"] + 3 * ["value"] + ["empty", "key", "less", "more"]):
            case "number":
                holder, key = chance.choice(numbers)
                holder[key] = _other_number(holder[key], chance)
            case "value":
                holder[key] = _value(chance)
            case "empty":
                holder[key] = type(holder[key])()
            case "key" if isinstance(holder, dict):
                holder[_word(chance)] = holder.pop(key)
            case "less":
                del holder[key]
            case _ if isinstance(holder, dict):
                holder[_word(chance)] = _value(chance)
            case _:
                holder.insert(key, chance.choice([holder[key], _value(chance)]))
    return content


def _places(content):
    """Each mapping or list with each of its keys."""
    for key in list(content) if isinstance(content, dict) else range(len(content)):
        yield content, key
        if isinstance(content[key], dict | list):
            yield from _places(content[key])


def _number(chance):
    """A number of any magnitude."""
    match chance.randrange(6):
        case 0:
            return chance.choice([0, -0.0, 1, 2, -1, 5e-324, 1.8e308, 2**31, 2**63, 2**64, 10**308])
        case 1:
            return chance.choice([1, -1]) * chance.randrange(10 ** chance.randrange(1, 320))
        case 2:
            return chance.randrange(100)
        case _:
            sign = chance.choice([1, 1, 1, -1])
            return sign * chance.uniform(1, 9) * 10 ** chance.uniform(-323, 307)


def _other_number(value, chance):
    """A number of any magnitude, or one beside a value, whole where that is."""
    if chance.random() < 0.5 or not isinstance(value, int | float):
        return _number(chance)
    other = value * 10 ** chance.gauss(0, chance.choice([0.1, 1, 10]))
    return round(other) if isinstance(value, int) else other


def _word(chance):
    """A word of the study, or of any characters and length."""
    match chance.randrange(4):
        case 0:
            return chance.choice(WORDS)
        case 1:
            letters = string.printable + ODD
            return "".join(chance.choices(letters, k=chance.choice([0, 1, 5, 30, 300])))
        case 2:
            return chance.choice(WORDS)[: chance.randrange(1, 9)] * chance.randrange(1, 30)
        case _:
            return chance.choice(WORDS).replace(chance.choice("abe_-=."), chance.choice(ODD))


def _value(chance, depth=0):
    """A value of any type."""
    match chance.randrange(4 if depth > 3 else 7):
        case 0:
            return chance.choice([None, True, False, "", [], {}])
        case 1 | 2:
            return _number(chance)
        case 3:
            return _word(chance)
        case 4:
            return str(_number(chance))
        case 5:
            return [_value(chance, depth + 1) for _ in range(chance.randrange(4))]
        case _:
            return {_word(chance): _value(chance, depth + 1) for _ in range(chance.randrange(4))}


def _dumped(content, chance):
    """The content as text, in one of the ways to write it."""
    if chance.random() < 0.5:
        return json.dumps(content, ensure_ascii=chance.random() < 0.5)
    return yaml.safe_dump(content, allow_unicode=True, default_flow_style=chance.random() < 0.3)


def _other_cells(text, chance):
    """A CSV text with other cells, or another number of them."""
    rows = [line.split(",") for line in text.splitlines()]
    for _ in range(chance.choice([1, 1, 2, 3])):
        row = chance.choice(rows[:1] + 3 * rows[1:])
        column = chance.randrange(len(row))
        match chance.randrange(9):
            case 0:
                row[column] = _word(chance)
            case 1:
                del row[column]
                row += [] if row else [""]
            case 2:
                row.insert(column, str(_number(chance)))
            case 3:
                rows.insert(chance.randrange(len(rows)), list(row))
            case 4:
                rows[1:] = chance.sample(rows[1:], len(rows) - 1)
            case 5:
                factor = 10 ** chance.gauss(0, 1)
                for other in rows[1:]:
                    with suppress(ValueError, IndexError):
                        other[column] = str(factor * float(other[column]))
            case 6:
                with suppress(ValueError):
                    row[column] = str(_other_number(float(row[column]), chance))
            case _:
                row[column] = str(_number(chance))
    between = chance.choice(",,,,,,;\t")
    if between == ";":
        rows = [[cell.replace(".", ",") for cell in row] for row in rows]
    return chance.choice(["\n", "\r\n"]).join(between.join(row) for row in rows)


def _strewn(text, chance):
    """A text with characters or lines that are cut, repeated, put in or exchanged."""
    for _ in range(chance.choice([1, 1, 2, 5, 20])):
        here, there = sorted(chance.randrange(len(text) + 1) for _ in range(2))
        there = min(there, here + chance.choice([1, 1, 4, 40, 400]))
        match chance.randrange(6):
            case 0:
                text = text[:here] + text[there:]
            case 1:
                text = text[:here] + chance.choice(string.printable + ODD) + text[here:]
            case 2:
                text = text[:here] + text[here:there] * chance.choice([2, 3, 100]) + text[there:]
            case 3:
                text = text[:here] + json.dumps(_value(chance)) + text[there:]
            case 4:
                lines = text.splitlines(keepends=True)
                chance.shuffle(lines)
                text = "".join(lines)
            case _:
                text = text[:here] + _word(chance) + text[there:]
        if not text:
            break
    return text
