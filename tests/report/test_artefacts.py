import pytest
from page_examples import ROOT, SOURCE

from boltjoint.config.study import load_study
from boltjoint.report.pages.artefacts import ArtefactFile, figures_and_tables
from boltjoint.study.contents import Contents
from boltjoint.study.published import Published


@pytest.mark.parametrize(
    ("stem", "expected"),
    [
        ("modes_three_bolt_free-4", ("modes", "three_bolt", "free-4", None, "structure")),
        ("natural_frequencies_free-4", ("natural_frequencies", None, "free-4", None, "structure")),
        ("contact", ("contact", None, None, None, "structure")),
        ("sampling", ("sampling", None, None, None, "overview")),
        ("contact_three_bolt_preload=37976", ("contact", "three_bolt", None, None, "structure")),
        ("program_three_bolt", ("program_three_bolt", None, None, None, "overview")),
        ("mesh_free-4", ("mesh", "free-4", None, None, "structure")),
        ("mesh_a_linear", ("mesh", "a_linear", None, None, "structure")),
        ("modes_free-4_free-8", ("modes", "free-4", "free-8", None, "structure")),
        ("modes_a_node-to-node_free-4", ("modes", "a_node-to-node", "free-4", None, "structure")),
        ("contact_a_linear_preload=1e+20", ("contact", "a_linear", None, None, "structure")),
        ("contact_contact_preload=10", ("contact", "contact", None, None, "structure")),
        ("deformation_free-4_preload=10", ("deformation", "free-4", None, None, "structure")),
        ("accuracy_free-8_free-4", ("accuracy", "free-8", "free-4", None, "free-8")),
        ("accuracy_a_free-4_b_free-4", ("accuracy", "a_free-4_b", "free-4", None, "a_free-4_b")),
        ("times_free-8_free-4_resonance=2", ("times", "free-8", "free-4", None, "free-8")),
        (
            "states_linear_free-4_node-to-node_linear_resonance=1",
            ("states", "linear", "free-4", "node-to-node", "linear"),
        ),
        ("mesh_four_bolt", ("mesh", "four_bolt", None, None, "structure")),
        (
            "loops_a_free-4_b_free-8_regions=6_elements=7",
            ("loops", "a_free-4_b", "free-8", "regions=6/elements=7", "a_free-4_b"),
        ),
        (
            "response_a_38kN_free-4_node-to-node_rdnm-1_resonance=2",
            ("response", "a_38kN", "free-4", "node-to-node", "a_38kN"),
        ),
        ("states_a_free-4", ("states", "a", "free-4", None, "a")),
        ("modes_enriched-8_enriched-40", ("modes", "enriched-8", "enriched-40", None, "structure")),
        ("accuracy_a_enriched-40", ("accuracy", "a", "enriched-40", None, "a")),
        ("patterns_four_bolt", ("patterns", "four_bolt", None, None, "accuracy")),
        ("bases_a_free-4_b", ("bases", "a_free-4_b", None, None, "accuracy")),
        ("divisions_a_enriched-40", ("divisions", "a", "enriched-40", None, "accuracy")),
        ("fits_a_enriched-40", ("fits", "a", "enriched-40", None, "a")),
        ("backbone_a_free-4_resonance=2", ("backbone", "a", "free-4", None, "a")),
        ("harmonics_a_free-4", ("harmonics", "a", "free-4", None, "a")),
        ("harmonic_peaks_a_enriched-4", ("harmonic_peaks", "a", "enriched-4", None, "a")),
        (
            "regions_a_enriched-8_clusters=auto",
            ("regions", "a", "enriched-8", "clusters=auto", "a"),
        ),
        (
            "elements_a_free-4_regions=auto_harmonic=3",
            ("elements", "a", "free-4", "regions=auto/harmonic=3", "a"),
        ),
        (
            "response_linear_free-4_clusters=12_table_backbone_resonance=1",
            ("response", "linear", "free-4", "clusters=12/table", "linear"),
        ),
        (
            "states_a_enriched-40_node-to-node_complex-rdnm-1_resonance=1",
            ("states", "a", "enriched-40", "node-to-node", "a"),
        ),
    ],
)
def test_names_of_files_tell_their_content(stem, expected):
    artefact = ArtefactFile.of(f"results/figures/{stem}.svg")
    page = artefact.page(["a", "a_38kN", "a_free-4_b", "free-8", "linear"])
    assert (artefact.kind, artefact.subject, artefact.basis, artefact.joint, page) == expected


def test_names_tell_in_what_a_response_is_solved():
    coordinates = ("linear", "backbone", "rdnm-2", "complex-rdnm-2")
    for name in coordinates:
        artefact = ArtefactFile.of(
            f"results/figures/response_a_free-4_node-to-node_{name}_resonance=1.svg"
        )
        assert (artefact.coordinates, artefact.resonance, artefact.subject) == (name, 1, "a")


def test_every_figure_and_table_of_the_study_is_on_its_page():
    study = load_study(ROOT)
    artefacts = [each for each in Contents(study).artefacts if each.form in ("figure", "table")]
    files = figures_and_tables([each.path for each in artefacts])
    assert [each.page(study.cases) for each in files] == [each.page for each in artefacts]
    assert [each.kind for each in files] == [each.kind for each in artefacts]


def test_the_study_has_every_figure_of_the_source_that_can_be_made():
    study = load_study(ROOT)
    found = set()
    for artefact in figures_and_tables([each.path for each in Contents(study).artefacts]):
        case = study.cases.get(artefact.page(study.cases))
        found.update(artefact.in_source(Published(SOURCE, case.published if case else None)))
    index = Published(SOURCE).figures()
    assert found == set(index.loc[index["not_made"] == "", "figure"])
