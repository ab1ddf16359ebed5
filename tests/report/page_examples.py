"""A case with results as files, and the pages written from them."""

import re
from pathlib import Path

import pandas as pd

from boltjoint.config.case import Case
from boltjoint.config.numerical_options import Solver
from boltjoint.config.study import load_study
from boltjoint.names import REFERENCE, Basis
from boltjoint.report.pages.accuracy import accuracy_page
from boltjoint.report.pages.case.page import case_page
from boltjoint.report.pages.overview import overview_page
from boltjoint.reproduction.pages import PagesBesideThesis
from boltjoint.study.artefact_list import Artefact
from boltjoint.study.stage_inputs import Results

ROOT = Path(__file__).parents[2]


SOURCE = ROOT / "resources" / "source"


DRAWING = """<?xml version="1.0"?>
<svg width="200pt" height="100.5pt" viewBox="0 0 200 100" xmlns="http://www.w3.org/2000/svg">
 <metadata>who made it</metadata>
 <defs><path id="mark" d="M 0.123456 -7.000001 L 1 1"/></defs>
 <g id="axes_1" transform="scale(0.015625)"><use href="#mark" clip-path="url(#frame)"/></g>
 <clipPath id="frame"/>
</svg>
"""


CASE = {
    "assembly": "three_bolt",
    "published": "three_bolt_constant",
    "preload_N": 37976,
    "contact": {
        "law": "constant",
        "tangential_stiffness_N_per_m": 1e8,
        "friction_coefficient": 0.1,
    },
    "forces_N": [0.001, 50],
    "modes": ["free-4"],
    "coordinates": ["linear", "rdnm-1"],
    "solve": [
        {"resonance": 1, "joints": ["node-to-node", "regions=6", "regions=6/elements=4"]},
        {"resonance": 2, "joints": ["node-to-node"]},
    ],
}


#: the joint of the case, of which pages need the number of elements
NODES = Artefact("joint", case="mine", basis=Basis("free-4"), joint=REFERENCE[0])


def source_of(case=None):
    """The thesis, of a case study or of none."""
    return PagesBesideThesis.among(map(str, SOURCE.iterdir()), case)


def save(artefact, frame=None):
    """Write a table, or a drawing as a figure."""
    path = Path(artefact.path)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(DRAWING if artefact.form == "figure" else frame.to_csv(index=False))
    return artefact


def results_of(artefacts):
    return Results([NODES.path, *(each.path for each in artefacts)])


def write(artefacts, solver=None, **changed):
    case, source = Case.model_validate(CASE | changed), source_of(CASE["published"])
    if "published" in changed:
        source = source_of(case.published)
    results = results_of(artefacts)
    return case_page("mine", case, solver or Solver(), artefacts, results, source, ["mine"])


def edit(kind, change):
    """Write a table of the case anew, changed by a function."""
    path = Artefact(kind, "table", case="mine", basis="free-4").path
    change(pd.read_csv(path, dtype={"source_table": str})).to_csv(path, index=False)


def repeated_ids(page):
    found = re.findall(r'<(?:figure|section)[^>]* id="([^"]+)"', page)
    return {each for each in found if found.count(each) > 1}


def plain(text):
    """Text with single spaces; those that do not break count as others."""
    return re.sub(r"\s+", " ", text)


def figure(page, anchor):
    """The text of a figure or table without its drawing."""
    found = re.search(rf'<figure [^>]*id="{re.escape(anchor)}">.*?</figure>', page, re.DOTALL)
    assert found, anchor
    text = re.sub(r"<svg.*?</svg>|<thead>|</?t[rd]>", " ", found[0], flags=re.DOTALL)
    return plain(re.sub("<.*?>", " ", text)).replace(" .", ".")


def overview_of(artefacts, **changed):
    """The cells of the rows of the table of the overview, after its heading."""
    case = Case.model_validate(CASE | changed)
    study = load_study(ROOT).model_copy(update={"cases": {"mine": case}})
    results = results_of(artefacts)
    page = overview_page(study, artefacts, artefacts, results, source_of())
    assert not repeated_ids(page)
    return rows_of(page, "The cases")


def reduced_models_of(artefacts, **changed):
    """The same of the table of reduced models."""
    case = Case.model_validate(CASE | changed)
    page = accuracy_page(artefacts, results_of(artefacts), source_of(), {"mine": case})
    return rows_of(page, "Errors of reduced models and time saved")


def rows_of(page, table):
    rows = re.findall(r"<tr.*?</tr>", page.split(f"{table}</strong>")[1], re.DOTALL)
    cells = [re.findall(r"<td.*?>(.*?)</td>", row) for row in rows[1:4]]
    return [[re.sub("<.*?>", "", cell) for cell in row] for row in cells]


def without_joints(blocks, *lost):
    left = [
        block | {"joints": [joint for joint in block["joints"] if joint not in lost]}
        for block in blocks
    ]
    return [block for block in left if block["joints"]]
