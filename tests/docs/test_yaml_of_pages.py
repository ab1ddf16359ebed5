"""YAML of the pages: the strict reader takes each block as the file, or part of one, that it is."""

import shutil

import numpy as np
import pytest
import yaml
from matrix_files import write_npz
from modal_files import write_universal
from page_blocks import ROOT, blocks
from scipy import sparse
from scipy.io import savemat

from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError

BLOCKS = blocks("yaml")
#: what the files of a page's own joint are called, where its assembly is of another type
NAMES = {"matrices": "joint", "deck": "beam", "plates": "lap", "flange": "tubes"}
#: two bricks upon each other, with the names of the example, and a bolt between them
DECK = """\
*NODE, NSET=ALL
1, 0., 0., 0.
2, 360., 0., 0.
3, 360., 25.4, 0.
4, 0., 25.4, 0.
5, 0., 0., 12.7
6, 360., 0., 12.7
7, 360., 25.4, 12.7
8, 0., 25.4, 12.7
9, 0., 0., 12.7
10, 360., 0., 12.7
11, 360., 25.4, 12.7
12, 0., 25.4, 12.7
13, 0., 0., 25.4
14, 360., 0., 25.4
15, 360., 25.4, 25.4
16, 0., 25.4, 25.4
100, 0., 0., 30.
*ELEMENT, TYPE=C3D8R, ELSET=BARS
1, 1, 2, 3, 4, 5, 6, 7, 8
2, 9, 10, 11, 12, 13, 14, 15, 16
*SURFACE, NAME=LOWER_INTERFACE, TYPE=ELEMENT
1, S2
*SURFACE, NAME=UPPER_INTERFACE, TYPE=ELEMENT
2, S1
*SURFACE, NAME=LOWER_PAD, TYPE=ELEMENT
1, S1
*SURFACE, NAME=UPPER_PAD, TYPE=ELEMENT
2, S2
*MATERIAL, NAME=STEEL
*ELASTIC
194000., 0.3
*DENSITY
8.0e-9
*SOLID SECTION, ELSET=BARS, MATERIAL=STEEL
*SURFACE, NAME=CUT, TYPE=ELEMENT
2, S1
*PRE-TENSION SECTION, SURFACE=CUT, NODE=100
0., 0., 1.
"""


def kind_of(content):
    """The kind of file that a block is, or is a part of."""
    if "vary" in content:
        return "sweeps"
    if content.keys() & {"bar", "type"} or "gap_um" in content.get("contact", ()):
        return "assemblies"
    return "cases"


def is_whole(content):
    return bool(content.keys() & {"vary", "bar", "type", "assembly"})


def page_of(block):
    return block.place.partition(":")[0]


def name_of(content, otherwise=None):
    """What the file of an assembly of another program is called."""
    if "modes" in content and "type" in content:
        return "tested" if "file" in content["modes"] else "reduced"
    return NAMES.get(content.get("type"), otherwise)


def whole(page, kind, name):
    """The block of a page that is a whole file."""
    (found,) = (
        each.text
        for each in BLOCKS
        if page_of(each) == page
        and kind_of(content := yaml.safe_load(each.text)) == kind
        and is_whole(content)
        and (kind == "assemblies" or content.get("assembly", name) == name)
        and name_of(content, name) == name
    )
    return found


def write(folder, kind, name, text):
    path = folder / f"config/{kind}/{name}.yaml"
    path.write_text(text, encoding="utf-8")


@pytest.fixture
def study(tmp_path):
    """The shipped configuration with the joint of the pages, and the files that they read."""
    shutil.copytree(ROOT / "config", tmp_path / "config")
    write(tmp_path, "assemblies", "mine", whole("docs/studies.md", "assemblies", "mine"))
    write(tmp_path, "cases", "mine", whole("docs/studies.md", "cases", "mine"))
    return tmp_path


def write_structure(folder, name):
    """What another program would have written: matrices, or a deck."""
    if name == "beam":
        (folder / "config/beam.inp").write_text(DECK)
    if name in ("beam", "lap", "tubes"):
        return
    if name in ("reduced", "tested"):
        write_modes(folder / "config", name)
        return
    count = 6000
    side = np.arange(3 * 20).reshape(20, 3)
    each = {"K": sparse.eye(count), "M": sparse.eye(count), "side_a": side, "side_b": side + 100}
    each |= {"area": np.ones(20), "position": np.zeros((20, 3)), "tip": np.zeros(count)}
    (folder / "config/matrices").mkdir()
    write_npz(folder / "config/matrices/joint.npz", each)


def write_modes(folder, name):
    """Three modes at twenty contact points, or at their nodes as of a test."""
    points = 20
    load = {"n0": np.ones(points), "area": np.ones(points)}
    if name == "reduced":
        rows = {"relative": np.ones((3 * points, 3)), "phi": np.ones((5, 3))}
        modes = {"f": [60.0, 90, 200], "zeta": [1e-3] * 3, "phi_shaker": np.ones(3)}
        gap = {"gap": np.zeros(points), "position": np.zeros((points, 3))}
        savemat(folder / "modes.mat", load | rows | modes | gap)
        return
    node = np.arange(101, 101 + 2 * points)
    test = {
        **{"node": node, "node_position": np.zeros((2 * points, 3))},
        **{"mode_shape": np.ones((6 * points, 3)), "modal_mass": np.full(3, 0.5)},
        "natural_frequency": [60.0, 90, 200],
    }
    write_universal(folder / "test.unv", test, ratio=1e-3)
    write_npz(folder / "contact.npz", load | {"side_a": node[:points], "side_b": node[points:]})


def merged(text, part):
    """A file with the keys of a part in place of its own."""
    content = yaml.safe_load(text)
    for key, value in yaml.safe_load(part).items():
        own = content.get(key)
        keeps = isinstance(own, dict) and "law" not in value
        content[key] = {**own, **value} if keeps else value
    return yaml.safe_dump(content)


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.place)
def test_blocks_are_read_as_the_files_that_they_are(block, study):
    content = yaml.safe_load(block.text)
    kind, name, changes = kind_of(content), "mine", {}
    surfaces = []
    if kind == "cases":
        surfaces = [each["name"] for each in content.get("contact", {}).get("surfaces", ())]
    if surfaces:
        name = "beam"
    elif "type" in content or "assembly" in content:
        name = content.get("assembly") or name_of(content)
    if name != "mine":
        case = whole("docs/structures.md", "cases", "joint")
        if name in ("beam", "lap", "tubes"):
            # its input is the point that its example names, and its pairs are few
            of_joint = "joint\n", "shaker", "enriched-24"
            for old, new in zip(of_joint, (f"{name}\n", "tip", "free-4"), strict=True):
                case = case.replace(old, new)
        elif name != "joint":
            for old, new in (("joint\n", f"{name}\n"), ("10000", "8000"), ("enriched-24", "all-3")):
                case = case.replace(old, new)
        write(study, "cases", name, case)
        assembly = whole("docs/structures.md", "assemblies", name)
        if surfaces:
            first, second = surfaces
            (lap,) = (line for line in assembly.splitlines() if "name: lap" in line)
            pad = lap.replace("lap", second).replace("_INTERFACE", "_PAD")
            # pads that vary in load need modes without the normal springs of closed contact
            assembly = assembly.replace("base: closed\n", "")
            assembly = assembly.replace(lap, f"{lap.replace('lap', first)}\n{pad}")
        write(study, "assemblies", name, assembly)
        write_structure(study, name)
    if is_whole(content):
        write(study, kind, name, block.text)
    else:
        path = study / f"config/{kind}/{name}.yaml"
        path.write_text(merged(path.read_text(), block.text), encoding="utf-8")
    if kind == "sweeps":
        changes["sweeps"] = [name]
    measured = content.get("measured", {})
    for curve in (*measured.get("curves", ()), *measured.get("responses", ())):
        (study / curve["file"]).parent.mkdir(exist_ok=True)
        # its columns stand in a comment beside it
        line = next(line for line in block.text.splitlines() if curve["file"] in line)
        columns = line.split("# ")[1]
        others = ",100,0.01" if "resonance" in curve else ",1,1,1"
        rows = "\n".join(f"{mode},{n}{others}" for mode in (1, 2, 3) for n in range(1, 9))
        (study / curve["file"]).write_text(f"{columns.replace(' ', '')}\n{rows}\n")
    read = load_study(study, {"cases": [name], **changes})
    assert list(read.cases) == [name]


def test_a_block_with_an_unknown_key_is_found(study):
    path = study / "config/cases/mine.yaml"
    path.write_text(path.read_text().replace("loss_factor", "loss_facter"), encoding="utf-8")
    with pytest.raises(ConfigError, match="did you mean loss_factor"):
        load_study(study, {"cases": ["mine"]})
