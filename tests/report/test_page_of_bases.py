from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from page_examples import CASE, ROOT, figure, repeated_ids, results_of, save, source_of, write

from boltjoint.config.case import Case
from boltjoint.config.study import load_study
from boltjoint.names import REFERENCE, Basis, Coordinates, JointName
from boltjoint.report.pages.overview import overview_page
from boltjoint.study.artefact_list import Artefact

OTHER_JOINTS = ("regions=6/table", "clusters=auto", "clusters=auto/harmonic=3")


@pytest.fixture
def artefacts_of_two_bases(artefacts):
    """The same, with joints that the source has not, in a basis that it has not either."""
    of_basis = {"case": "mine", "basis": Basis("enriched-40")}
    solved = [(JointName(joint), REFERENCE[1]) for joint in OTHER_JOINTS]
    solved += [
        (REFERENCE[0], Coordinates(name)) for name in ("linear", "complex-rdnm-1", "backbone")
    ]
    figures = [
        Artefact(
            "response", "figure", **of_basis, joint=joint, coordinates=coordinates, resonance=1
        )
        for joint, coordinates in solved
    ]
    figures += [
        Artefact("backbone", "figure", **of_basis, resonance=1),
        Artefact("regions", "figure", **of_basis, joint=JointName("clusters=auto")),
        Artefact("loops", "figure", **of_basis, joint=JointName("clusters=auto/harmonic=3")),
    ]
    both = [*artefacts, *map(save, figures)]
    for kind in ("accuracy", "times"):
        (table,) = (each for each in artefacts if each.kind == kind)
        frame = pd.read_csv(table.path).query("joint == 'node-to-node' and coordinates == 'linear'")
        both.append(save(replace(table, **of_basis), frame))
    return both


@pytest.fixture
def page_of_two_bases(artefacts_of_two_bases):
    blocks = [
        *CASE["solve"],
        {
            "resonance": 1,
            "modes": ["enriched-40"],
            "coordinates": ["linear"],
            "joints": OTHER_JOINTS,
        },
        {
            "resonance": 1,
            "modes": ["enriched-40"],
            "coordinates": ["linear", "complex-rdnm-1", "backbone"],
            "joints": ["node-to-node"],
        },
    ]
    return write(artefacts_of_two_bases, solve=blocks)


def test_every_basis_has_its_own_part_of_the_page(page_of_two_bases):
    page = page_of_two_bases
    assert not repeated_ids(page)
    for anchor in ("nodes", "regions", "elements", "accuracy", "times"):
        for family in ("free-4", "enriched-40"):
            assert f'id="{anchor}-{family}"' in page, (anchor, family)
    # what is not solved there has no place there
    assert 'id="resonance-2-free-4"' in page
    assert 'id="resonance-2-enriched-40"' not in page
    assert 'id="backbones-enriched-40"' in page
    assert 'id="backbones-free-4"' not in page


def test_the_source_is_beside_its_own_basis_only(page_of_two_bases):
    where = "response_mine_{}_node-to-node_linear_resonance=1"
    assert "Figure 3.9 of the source" in figure(page_of_two_bases, where.format("free-4"))
    assert "of the source" not in figure(page_of_two_bases, where.format("enriched-40"))


def test_joints_and_coordinates_are_said_in_words(page_of_two_bases):
    where = "response_mine_enriched-40"
    for stem, words in {
        "node-to-node_complex-rdnm-1": "Node-to-node, 1 complex response-dependent mode",
        "node-to-node_backbone": "Node-to-node, backbone",
        "regions=6_table_linear": "6 regions, tabulated, linear modes",
        "clusters=auto_linear": "Clusters to tolerance, linear modes",
        "clusters=auto_harmonic=3_linear": "Clusters to tolerance of 3 elements, harmonic fit",
    }.items():
        assert words in figure(page_of_two_bases, f"{where}_{stem}_resonance=1")


def test_loops_are_those_of_the_fit_only_where_it_fits_loops(page_of_two_bases):
    fitted = figure(page_of_two_bases, "loops_mine_free-4_regions=6_elements=4")
    harmonic = figure(page_of_two_bases, "loops_mine_enriched-40_clusters=auto_harmonic=3")
    assert "three amplitudes of the fit" in fitted
    assert "three amplitudes." in harmonic


def test_facts_name_every_basis_and_how_regions_move(artefacts, page_of_two_bases):
    facts = figure(page_of_two_bases, "case-table")
    assert "basis free-4, enriched-40 the first four bending modes" in facts
    assert "motion of a region mean of its pairs mean of its pairs" in facts
    weighted = write(artefacts, regions={"motion": "load-weighted"})
    assert "mean of its pairs, weighted by load" in figure(weighted, "case-table")


def test_only_the_basis_of_the_source_is_numbered_as_in_the_source(artefacts):
    others = [replace(each, basis=Basis("free-8")) for each in artefacts]
    for each, other in zip(artefacts, others, strict=True):
        Path(other.path).write_bytes(Path(each.path).read_bytes())
    page = write([*artefacts, *others], modes=["free-4", "free-8"])
    assert not repeated_ids(page)
    stem = "response_mine_{}_node-to-node_linear_resonance=1"
    assert "Figure 3.9 of the source" in figure(page, stem.format("free-4"))
    assert "of the source" not in figure(page, stem.format("free-8"))
    elements = "elements_mine_free-8_regions=6_elements=4-table"
    assert "Fitted elements" in figure(page, elements)
    assert "source" not in figure(page, elements)
    assert "published" not in figure(page, elements)
    assert 'id="table-3.3-free-4"' in page
    assert 'id="table-3.3-free-8"' not in page
    assert "published" not in figure(page, "times_mine_free-8-table")
    assert "published" in figure(page, "times_mine_free-4-table")
    study = load_study(ROOT)
    case = Case.model_validate(CASE | {"modes": ["free-8"]})
    alone = study.model_copy(update={"cases": {"mine": case}})
    overview = overview_page(alone, [], others, results_of([]), source_of())
    assert "mine.html#table-3" not in overview
    assert "mine.html#response" not in overview
