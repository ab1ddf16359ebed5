import base64
import gzip
import inspect
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from boltjoint import dataset
from boltjoint.config.case import Case
from boltjoint.config.solver import Solver
from boltjoint.config.study import load_study
from boltjoint.names import PAGES
from boltjoint.report.pages import accuracy, markup, overview, structure
from boltjoint.report.pages import case as page_of_case
from boltjoint.report.pages.shown import Shown, figures_and_tables, shown_on
from boltjoint.study import layout
from boltjoint.study.published import Published
from boltjoint.verification.residual_in_time import residuals_in_time

ROOT = Path(__file__).parents[1]
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


@pytest.fixture
def files(tmp_path):
    """Figures and tables of a case ``mine``, with one figure that no page expects."""
    (tmp_path / "figures").mkdir()
    (tmp_path / "tables").mkdir()
    stems = [
        f"response_mine_free-4_{joint}_{coordinates}_resonance={resonance}"
        for resonance, joints in {
            1: ("node-to-node", "regions=6", "regions=6_elements=4"),
            2: ("node-to-node",),
        }.items()
        for joint in joints
        for coordinates in ("linear", "rdnm-1")
    ]
    stems += [
        "regions_mine_free-4_regions=6",
        "loops_mine_free-4_regions=6_elements=4",
        "states_mine_free-4_node-to-node_linear_resonance=1",
        "surprise_mine_free-4",
    ]
    for stem in stems:
        (tmp_path / f"figures/{stem}.svg").write_text(DRAWING)
    solved = pd.DataFrame(
        [
            {"joint": joint, "coordinates": coordinates, "resonance": 1, "force_N": force}
            for joint in ("node-to-node", "regions=6", "regions=6/elements=4")
            for coordinates in ("linear", "rdnm-1")
            for force in CASE["forces_N"]
        ]
    )
    broken = (solved["coordinates"] == "rdnm-1") & (solved["force_N"] == 50)
    folded = (solved["joint"] == "regions=6") & (solved["force_N"] == 50)
    accuracy = solved.assign(
        complete=~broken,
        peak_frequency_Hz=np.where(broken, np.nan, 70.61234),
        peak_mm_per_N=1.5,
        peak_frequency_error_percent=np.where(broken, np.nan, -1.25),
        peak_amplitude_error_percent=np.where(broken, np.nan, 20.0),
        curve_error_dB=0.5,
        estimated_peak_error_percent=np.where(solved["coordinates"] == "rdnm-1", 0.7, 0.0),
        estimated_largest_error_percent=0.9,
        energy_error=1e-3,
        residual=0.02,
        wrong=False,
        fell_back=False,
        turning_points=np.where(folded, 2, 0),
        folded_from_Hz=np.where(folded, 71.25, np.nan),
        folded_to_Hz=np.where(folded, 72.5, np.nan),
        residual_in_time=1e-7,
        worst_in_time_Hz=70.5,
        reason=np.where(broken, "the path would turn back", None),
    )
    times = solved.assign(
        cpu_s=0.1,
        cpu_forward_difference_s=0.3,
        reduction_percent=10.0,
        reduction_forward_difference_percent=40.0,
        complete=True,
    ).merge(
        Published(SOURCE, "three_bolt_constant").time_reductions().assign(resonance=1),
        how="left",
        on=["joint", "coordinates", "resonance", "force_N"],
    )
    elements = pd.DataFrame(
        {
            "region": [1, 1],
            "element": [1, 2],
            "k_kN_per_mm": [1.0, 2.0],
            "slip_force_N": [100.0, 200.0],
            "published_k_kN_per_mm": [1.5, 2.5],
            "published_slip_force_N": [400.0, 300.0],
            "source_table": "3.5",
        }
    )
    for stem, frame in {
        "accuracy_mine_free-4": accuracy,
        "times_mine_free-4": times,
        "elements_mine_free-4_regions=6_elements=4": elements,
        "regions_mine_free-4_regions=6": pd.DataFrame({"region": [1, 2], "elements": [5, 6]}),
    }.items():
        frame.to_csv(tmp_path / f"tables/{stem}.csv", index=False)
    joint = xr.Dataset({"slip_force": ("element", np.ones(1178), {"units": "N"})})
    dataset.save(joint, tmp_path / "node-to-node/joint.nc")
    return sorted(str(path) for path in tmp_path.rglob("*.*"))


@pytest.fixture
def page(files):
    return write(files)


def write(files, solver=None, **changed):
    case, source = Case.model_validate(CASE | changed), Published(SOURCE, CASE["published"])
    if "published" in changed:
        source = Published(SOURCE, case.published)
    return page_of_case.page("mine", case, solver or Solver(), files, source, ["mine"])


def edit(files, stem, change):
    """Write a table anew, changed by a function."""
    (path,) = (path for path in files if path.endswith(f"tables/{stem}.csv"))
    change(pd.read_csv(path, dtype={"source_table": str})).to_csv(path, index=False)


def repeated_ids(page):
    found = re.findall(r'<(?:figure|section)[^>]* id="([^"]+)"', page)
    return {each for each in found if found.count(each) > 1}


def figure(page, anchor):
    """The text of a figure or table without its drawing."""
    found = re.search(rf'<figure [^>]*id="{re.escape(anchor)}">.*?</figure>', page, re.DOTALL)
    assert found, anchor
    text = re.sub(r"<svg.*?</svg>|<thead>|</?t[rd]>", " ", found[0], flags=re.DOTALL)
    # spaces that do not break count as others
    return re.sub(r"\s+", " ", re.sub("<.*?>", " ", text)).replace(" .", ".")


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
def test_names_tell_what_a_figure_shows(stem, expected):
    shown = Shown.of(f"results/figures/{stem}.svg")
    page = shown.page(["a", "a_38kN", "a_free-4_b", "free-8", "linear"])
    assert (shown.kind, shown.subject, shown.modes, shown.joint, page) == expected


def test_names_tell_in_what_a_response_is_solved():
    coordinates = ("linear", "backbone", "rdnm-2", "complex-rdnm-2")
    for name in coordinates:
        shown = Shown.of(f"results/figures/response_a_free-4_node-to-node_{name}_resonance=1.svg")
        assert (shown.coordinates, shown.resonance, shown.subject) == (name, 1, "a")


def test_nothing_of_the_study_is_shown_without_its_place():
    for shown in figures_and_tables(layout.targets(load_study(ROOT))):
        assert shown.subject or shown.kind in ("contact", "natural_frequencies", "sampling")


def test_every_figure_and_table_of_the_study_has_a_page():
    study = load_study(ROOT)
    targets = layout.targets(study)
    shown = [
        path for page in (*PAGES, *study.cases) for path in shown_on(page, targets, study.cases)
    ]
    assert sorted(shown) == sorted(each.path for each in figures_and_tables(targets))
    assert len(set(shown)) == len(shown) > 0


def test_the_study_has_every_figure_of_the_source_that_can_be_made():
    study = load_study(ROOT)
    found = set()
    for shown in figures_and_tables(layout.targets(study)):
        case = study.cases.get(shown.page(study.cases))
        found.update(shown.in_source(Published(SOURCE, case.published if case else None)))
    index = Published(SOURCE).figures()
    assert found == set(index.loc[index["not_made"] == "", "figure"])


def test_a_figure_tells_its_number_in_the_source_and_its_errors(page):
    response = figure(page, "response_mine_free-4_node-to-node_linear_resonance=1")
    assert "Figure 3.9 of the source" in response
    assert "The peak lies at 70.6 Hz with 0.001 N" in response
    reduced = figure(page, "response_mine_free-4_regions=6_elements=4_rdnm-1_resonance=1")
    assert "Figure 3.21 of the source" in reduced
    assert "20 % in amplitude (at 0.001 N)" in reduced
    assert "Broken off at 50 N: the path would turn back." in reduced
    assert "of the source" not in figure(
        page, "response_mine_free-4_node-to-node_rdnm-1_resonance=2"
    )


def test_a_figure_of_several_in_the_source_tells_all_their_numbers(files):
    states = "states_mine_free-4_node-to-node_linear_resonance=1"
    page = write(files, published="three_bolt_variable")
    assert "Figures 3.46 to 3.51 of the source" in figure(page, states)
    assert "of the source" not in figure(write(files), states)


def test_published_times_stand_beside_ours(page):
    nodes = figure(page, "table-3.3-free-4")
    assert "0.001 0.3 685.3 0.3 295.8 40.00 56.84" in nodes
    regions = figure(page, "table-3.4-free-4")
    assert "50 40.00 99.74 40.00 99.90" in regions


def test_sums_of_slip_forces_stand_beside_each_other(page):
    assert "300 N here, 700 N in the source" in figure(page, "table-3.5-free-4")


def test_facts_stand_beside_those_of_the_source(page):
    facts = figure(page, "case-table")
    assert "preload per bolt (N) 37976 10000" in facts
    assert "friction elements, node to node 1178 1183" in facts
    assert "loss factor 0.002 not given" in facts
    assert "add up to what 37976 N per bolt would give" in page


def test_facts_tell_how_friction_is_solved(files):
    exact = write(files)
    assert "friction forces analytic describing function – harmonics of the response 1" in figure(
        exact, "case-table"
    )
    assert "time samples of a period" not in exact
    assert "first-harmonic" not in exact
    sampled = write(files, Solver(friction_force="aft", harmonics=3, time_samples=128))
    facts = figure(sampled, "case-table")
    assert "friction forces alternating frequency/time (AFT) – harmonics of the response 3" in facts
    assert "time samples of a period 128" in facts
    assert "those of its first-harmonic amplitude" in sampled


OTHER_JOINTS = ("regions=6/table", "clusters=auto", "clusters=auto/harmonic=3")


@pytest.fixture
def files_of_two_bases(files, tmp_path):
    """The same, with joints that the source has not, in a basis that it has not either."""
    where = "mine_enriched-40"
    stems = [
        f"response_{where}_{joint.replace('/', '_')}_linear_resonance=1"
        for joint in ("node-to-node", *OTHER_JOINTS)
    ]
    stems += [
        f"response_{where}_node-to-node_{coordinates}_resonance=1"
        for coordinates in ("complex-rdnm-1", "backbone")
    ]
    stems += [
        f"backbone_{where}_resonance=1",
        f"regions_{where}_clusters=auto",
        f"loops_{where}_clusters=auto_harmonic=3",
    ]
    for stem in stems:
        (tmp_path / f"figures/{stem}.svg").write_text(DRAWING)
    for kind in ("accuracy", "times"):
        (path,) = tmp_path.rglob(f"{kind}_mine_free-4.csv")
        frame = pd.read_csv(path).query("joint == 'node-to-node' and coordinates == 'linear'")
        frame.to_csv(tmp_path / f"tables/{kind}_{where}.csv", index=False)
    return sorted(str(path) for path in tmp_path.rglob("*.*"))


@pytest.fixture
def page_of_two_bases(files_of_two_bases):
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
    return write(files_of_two_bases, solve=blocks)


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


def test_facts_name_every_basis_and_how_regions_move(files, page_of_two_bases):
    facts = figure(page_of_two_bases, "case-table")
    assert "basis free-4, enriched-40 the first four bending modes" in facts
    assert "motion of a region mean of its pairs mean of its pairs" in facts
    weighted = write(files, regions={"motion": "load-weighted"})
    assert "mean of its pairs, weighted by load" in figure(weighted, "case-table")


def test_regions_whose_number_a_tolerance_decides_stand_after_numbers(files):
    joints = ["node-to-node", "regions=auto", "regions=12", "regions=6"]
    facts = figure(write(files, solve=[{"resonance": 1, "joints": joints}]), "case-table")
    assert "regions 6, 12, auto" in facts


def without_reference(frame):
    """No response is compared with another, and none of linear modes is there."""
    return without_errors(frame[frame["coordinates"] != "linear"])


def without_nodes(frame):
    """The same where no node-to-node joint is solved."""
    return without_errors(frame[frame["joint"] != "node-to-node"])


def with_broken_reference(frame):
    """The reference broke off at every force."""
    is_reference = (frame["joint"] == "node-to-node") & (frame["coordinates"] == "linear")
    reason = frame["reason"].where(~is_reference, "no solution found")
    return without_errors(frame).assign(complete=frame["complete"] & ~is_reference, reason=reason)


def without_errors(frame):
    errors = [name for name in frame if "_error_" in name]
    return frame.assign(**dict.fromkeys(errors, np.nan)).drop(columns="residual_in_time")


def without_joints(blocks, *lost):
    left = [
        block | {"joints": [joint for joint in block["joints"] if joint not in lost]}
        for block in blocks
    ]
    return [block for block in left if block["joints"]]


WITHOUT_REFERENCE = {
    "no linear modes": (without_reference, {"coordinates": ["rdnm-1"]}),
    "no node-to-node joint": (
        without_nodes,
        {"solve": without_joints(CASE["solve"], "node-to-node")},
    ),
    "a reference that broke off": (with_broken_reference, {}),
}


@pytest.mark.parametrize("situation", WITHOUT_REFERENCE)
def test_a_case_without_a_reference_has_its_page(files, situation):
    change, changed = WITHOUT_REFERENCE[situation]
    edit(files, "accuracy_mine_free-4", change)
    edit(files, "times_mine_free-4", lambda frame: frame.assign(reduction_percent=np.nan))
    page = write(files, **changed)
    assert 'id="accuracy-free-4"' in page
    assert "Peaks differ from the reference's" not in page
    assert not re.search(r"\bnan\b", re.sub("<svg.*?</svg>", "", page, flags=re.DOTALL))
    if not changed:
        reference = figure(page, "response_mine_free-4_node-to-node_linear_resonance=1")
        assert "Broken off at 0.001, 50 N: no solution found." in reference


@pytest.mark.parametrize("situation", WITHOUT_REFERENCE)
def test_a_case_without_a_reference_stands_in_the_overview(files, situation):
    change, changed = WITHOUT_REFERENCE[situation]
    edit(files, "accuracy_mine_free-4", change)
    # frequency and response at both forces
    assert overview_of(files, **changed)[1][4:8] == ["–"] * 4
    assert overview_of(files, "What is cheaper", **changed)[1][1] == "–"


def overview_of(files, table="The cases", **changed):
    """The cells of the rows of a table of the overview, after its heading."""
    case = Case.model_validate(CASE | changed)
    study = load_study(ROOT).model_copy(update={"cases": {"mine": case}})
    page = overview.page(study, files, shown_on("mine", files, ["mine"]), Published(SOURCE))
    assert not repeated_ids(page)
    rows = re.findall(r"<tr.*?</tr>", page.split(f"{table}</strong>")[1], re.DOTALL)
    cells = [re.findall(r"<td.*?>(.*?)</td>", row) for row in rows[1:4]]
    return [[re.sub("<.*?>", "", cell) for cell in row] for row in cells]


def test_folds_wrong_peaks_and_what_stands_in_their_place_are_named(files):
    def doubt(frame):
        rdnm = frame["coordinates"] == "rdnm-1"
        estimate = np.where(rdnm & (frame["force_N"] == 50), 832.0, 0.7)
        instead = rdnm & (frame["force_N"] == 0.001)
        wrong = rdnm & (frame["force_N"] == 50)
        errors = {
            "estimated_peak_error_percent": estimate,
            "estimated_largest_error_percent": 2 * estimate,
        }
        return frame.assign(**errors, wrong=wrong, fell_back=instead)

    edit(files, "accuracy_mine_free-4", doubt)
    page = write(files)
    of_regions = figure(page, "response_mine_free-4_regions=6_linear_resonance=1")
    assert (
        "Several solutions belong to one frequency at 50 N between 71.25 and 72.50 Hz "
        "(2 turning points): sweeps up and down the frequency show different ones."
    ) in of_regions
    in_one_mode = figure(page, "response_mine_free-4_node-to-node_rdnm-1_resonance=1")
    assert "Several solutions" not in in_one_mode
    assert "The response to 50 N is wrong" in in_one_mode
    assert "it is off by up to 1664 % of the peak, the peak by up to 832 %." in in_one_mode
    assert "At 0.001 N the response in linear modes stands in its place." in in_one_mode
    assert "is wrong" not in of_regions


def test_what_comes_from_results_is_escaped(files):
    hostile = "<script>alert(1)</script>"

    def attack(frame):
        return frame.assign(reason=np.where(frame["complete"], None, hostile))

    edit(files, "accuracy_mine_free-4", attack)
    page = write(files)
    assert hostile not in page
    # in the verdict and in the table
    assert page.count("&lt;script&gt;alert(1)&lt;/script&gt;") >= 2


@pytest.mark.parametrize(
    ("residual", "printed"), [(9.9e-7, "below 10⁻⁶"), (3.21e-4, "0.00032"), (np.nan, "–")]
)
def test_a_residual_in_time_says_no_more_than_the_march_resolves(files, residual, printed):
    edit(files, "accuracy_mine_free-4", lambda frame: frame.assign(residual_in_time=residual))
    assert printed in write(files).split('id="accuracy-free-4"')[1]
    assert overview_of(files)[1][-1] == printed
    assert markup.IN_TIME == inspect.signature(residuals_in_time).parameters["tolerance"].default


def test_how_far_one_harmonic_is_off_stands_first(tmp_path):
    table = pd.DataFrame(
        {
            "force_N": [1.0, 1.0, 10.0, 10.0],
            "harmonics": [1, 9] * 2,
            "peak_frequency_error_percent": [0.3, 0.0, 1.1, 0.0],
            "peak_amplitude_error_percent": [-8.0, 0.0, -40.4, 0.0],
        }
    )
    (tmp_path / "tables").mkdir()
    paths = [
        tmp_path / f"tables/harmonic_peaks_mine_{basis}.csv" for basis in ("free-4", "enriched-8")
    ]
    # the basis without contact errs by less, and is not what counts
    for path, share in zip(paths, (0.1, 1.0), strict=True):
        errors = table.filter(like="error") * share
        table.assign(**errors).to_csv(path, index=False)
    files = list(map(str, paths))
    page = accuracy.page(files, Published(SOURCE), ["mine"])
    lead = page.split("</header>")[0]
    assert "The reference of all errors is converged in the basis, with one harmonic." in lead
    assert "off by up to 40 % in amplitude and 1.1 % in frequency" in lead
    assert "at 1, 10 N" in lead
    three = [frame.assign(harmonics=[3, 9] * 2) for frame in map(pd.read_csv, files)]
    for path, frame in zip(paths, three, strict=True):
        frame.to_csv(path, index=False)
    lead = accuracy.page(files, Published(SOURCE), ["mine"]).split("</header>")[0]
    assert "converged in the basis, with harmonics up to 3." in lead
    without = accuracy.page([], Published(SOURCE), ["mine"]).split("</header>")[0]
    assert "was not computed" in without


def test_peaks_of_paths_that_broke_off_are_not_shown(files):
    def break_off(frame):
        lost = frame["force_N"] == 50
        return frame.assign(complete=~lost, peak_frequency_Hz=71.5)

    edit(files, "accuracy_mine_free-4", break_off)
    peaks = re.search(r"Peaks of the node-to-node joint</strong>.*?</table>", write(files), re.S)
    assert re.findall(r"<td.*?>(.*?)</td>", peaks[0])[5:] == ["50", *["–"] * 4]
    assert overview_of(files)[1][4:8] == ["71.5", "1.5", "–", "–"]
    assert overview_of(files, "What is cheaper")[1][1] == "20.00"


def test_nothing_is_saved_where_no_joint_is_fitted(files):
    cheaper = "What is cheaper"
    assert overview_of(files, cheaper)[1][-2:] == ["10.00", "40.00"]
    solve = without_joints(CASE["solve"], "regions=6/elements=4")
    assert overview_of(files, cheaper, solve=solve)[1][-2:] == ["–", "–"]


def test_only_the_basis_of_the_source_is_numbered_as_in_the_source(files):
    both = list(files)
    for path in files:
        other = path.replace("mine_free-4", "mine_free-8")
        if other != path:
            Path(other).write_bytes(Path(path).read_bytes())
            both.append(other)
    page = write(both, modes=["free-4", "free-8"])
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
    shown = [path for path in both if "free-8" in path]
    assert "mine.html#table-3" not in overview.page(alone, [], shown, Published(SOURCE))
    assert "mine.html#response" not in overview.page(alone, [], shown, Published(SOURCE))


def structure_of(names, files=()):
    assemblies = load_study(ROOT).assemblies
    other = assemblies["three_bolt"].material.model_copy(update={"youngs_modulus_GPa": 210.0})
    mine = assemblies["three_bolt"].model_copy(update={"material": other})
    assemblies = {name: assemblies.get(name, mine) for name in names}
    return structure.page(assemblies, list(files), Published(SOURCE), ["mine"])


def test_material_of_the_source_stands_beside_its_assemblies():
    of_source = figure(structure_of(["three_bolt", "mine"]), "dimensions-table")
    assert "The source has three_bolt. Its dimensions are not known" in of_source
    assert "Young's modulus (GPa) 190 210 190" in of_source.replace("&#x27;", "'")
    assert "Table 3.1 of the source" in of_source
    own = figure(structure_of(["mine"]), "dimensions-table")
    assert "source" not in own
    assert "calibrated" not in own


def test_figures_of_any_assembly_are_captioned(tmp_path):
    stems = {
        "mesh_free-4": "Mesh of free-4",
        "modes_a_linear_free-4": "Bending modes of a_linear",
        "contact_a_node-to-node_preload=1e+20": "a_node-to-node with 1e+20 N per bolt",
        "deformation_free-4_preload=10": "Shape of free-4 with 10 N per bolt",
    }
    (tmp_path / "figures").mkdir()
    (tmp_path / "tables").mkdir()
    for stem in stems:
        (tmp_path / f"figures/{stem}.svg").write_text(DRAWING)
    contact = {"assembly": ["a_linear"], "published_pairs": [np.nan], "pairs": [10]}
    pd.DataFrame(contact).to_csv(tmp_path / "tables/contact.csv", index=False)
    page = structure_of(["mine"], map(str, sorted(tmp_path.rglob("*.*"))))
    for stem, title in stems.items():
        assert figure(page, stem).strip().startswith(title)
    assert not repeated_ids(page)
    assert "published numbers" not in page


def test_what_no_section_expects_is_shown_at_the_end(page):
    assert page.index('id="further"') < page.index('id="surprise_mine_free-4"')


def test_what_a_case_lacks_is_left_out(files):
    some = [path for path in files if "times" not in path and "regions=6" not in path]
    page = write(some, published=None)
    assert 'id="times-free-4"' not in page
    assert "in the source" not in page
    assert 'id="response_mine_free-4_node-to-node_linear_resonance=1"' in page


def test_the_same_files_give_the_same_page(files):
    assert write(files) == write(files)
    assert markup.packed(write(files)) == markup.packed(write(files))


def test_index_says_where_the_source_stands_and_why_not(files):
    study = load_study(ROOT)
    text = overview.page(study, [], layout.targets(study), Published(SOURCE))
    assert "three_bolt_constant.html#response_three_bolt_constant_free-4_node-to-node" in text
    assert 'four_bolt_variable.html#table-3.21-3.22-free-4"' in text
    assert "not made: explains the method and holds no data" in text
    alone = study.model_copy(update={"cases": {"mine": Case.model_validate(CASE)}})
    text = overview.page(alone, [], shown_on("mine", files, ["mine"]), Published(SOURCE))
    assert "no case of this study is compared with it" in text
    assert "not computed in this study" in text


@pytest.fixture
def page_of_accuracy(tmp_path):
    """The page of one case that has everything and of another that has nothing."""
    peak = {"peak_frequency_error_percent": -0.5, "peak_amplitude_error_percent": 2.0}
    rows = {
        "patterns_three_bolt": {
            "basis": ["free-4", "free-4", "enriched-8", "enriched-8"],
            "vectors": [4, 4, 8, 8],
            "springs": "x",
            "pattern": ["all", "left", "all", "left"],
            "resonance": 1,
            "frequency_Hz": 100.0,
            "error_percent": [51.5, 3.0, 0.25, 0.125],
        },
        "models_mine": {
            "modes": ["free-4", "enriched-8"],
            "joint": "node-to-node",
            "coordinates": ["rdnm-1", "linear"],
            "resonance": 1,
            "force_N": 5.0,
            "complete": [False, True],
            **peak,
            "cpu_s": 1.0,
        },
        "bases_mine": {
            "basis": ["free-4", "free-4", "enriched-8"],
            "vectors": [4, 4, 8],
            "force_N": [1.0, 5.0, 1.0],
            **peak,
            "peak_amplitude_error_percent": [-77.0, 12.0, 0.0],
        },
        "divisions_mine_enriched-8": {
            "division": "clusters",
            "motion": "mean",
            "regions": [2, 2, 4],
            "region_error_percent": 1.5,
            "force_N": [1.0, 5.0, 1.0],
            **peak,
        },
    }
    for folder in ("tables", "figures"):
        (tmp_path / folder).mkdir()
    for stem, content in rows.items():
        pd.DataFrame(content).to_csv(tmp_path / f"tables/{stem}.csv", index=False)
        (tmp_path / f"figures/{stem}.svg").write_text(DRAWING)
    files = sorted(str(path) for path in tmp_path.rglob("*.*"))
    return accuracy.page(files, Published(SOURCE), ["mine", "other"])


def test_page_of_accuracy_has_structure_models_bases_and_regions(page_of_accuracy):
    sections = re.findall('<section id="([^"]+)"', page_of_accuracy)
    assert sections == [
        "how",
        "patterns",
        *("case-mine", "models-mine", "bases-mine", "divisions-mine"),
    ]
    assert len(re.findall("<svg", page_of_accuracy)) == 4
    assert page_of_accuracy.count('href="../tables/') == 4
    assert not repeated_ids(page_of_accuracy)


def test_page_of_accuracy_sums_up_by_the_largest_errors(page_of_accuracy):
    tables = {
        re.search("<strong>(.*?)</strong>", each)[1]: [
            [re.sub("<.*?>", "", cell) for cell in re.findall("<td.*?</td>", row)]
            for row in re.findall("<tr.*?</tr>", each)
        ][-2:]
        for each in re.findall('<figure class="tabular".*?</figure>', page_of_accuracy, re.S)
        if "Every" not in each
    }
    assert tables["Largest errors in three_bolt, over all patterns"] == [
        ["free-4", "4", "51.50"],
        ["enriched-8", "8", "0.25"],
    ]
    # that of the models, of the bases and of the regions; the last one stands here
    assert tables["Largest errors over all forces"] == [
        ["clusters", "mean", "2", "1.50", "0.50", "2.00"],
        ["", "", "4", "1.50", "0.50", "2.00"],
    ]
    assert ["free-4", "4", "0.50", "77.00"] in [
        [re.sub("<.*?>", "", cell) for cell in re.findall("<td.*?</td>", row)]
        for row in re.findall("<tr.*?</tr>", page_of_accuracy)
    ]


def test_drawing_keeps_only_what_it_needs():
    drawn = markup.inline_svg(DRAWING, "a-", "Title")
    assert drawn.startswith("<svg")
    assert "who made it" not in drawn
    assert 'id="a-mark"' in drawn
    assert 'href="#a-mark"' in drawn
    assert "url(#a-frame)" in drawn
    assert "axes_1" not in drawn
    assert 'd="M 0.12 -7.00 L 1 1"' in drawn
    assert "scale(0.015625)" in drawn
    assert "max-width: 284px" in drawn


def test_packed_page_holds_the_page_without_links_to_files(page):
    assert '<a href="structure.html">' in page
    packed = markup.packed(page)
    data = re.search('id="packed">(.*?)</script>', packed)[1]
    unpacked = gzip.decompress(base64.b64decode(data)).decode()
    assert "Node-to-node joint" in unpacked
    assert "#case" in unpacked
    assert not re.search('href="[^#]', unpacked)
    assert len(packed) < len(page)


def test_a_page_too_long_for_a_frame_is_reported(caplog):
    noise = np.random.default_rng(0).bytes(2_000_000).hex()
    markup.packed(f"<title>Long</title>{noise}")
    assert "'Long' is too long for a frame" in caplog.text


def test_numbers_of_a_column_have_the_same_decimals():
    frame = pd.DataFrame(
        {
            "force_N": [0.001, 50.0],
            "peak_frequency_Hz": [101.98984, 70.6171],
            "error_percent": [-0.0001, 12.345],
            "residual": [4.26e-8, 1e-3],
            "complete": [True, False],
            "reason": [None, "a < b"],
        }
    )
    text = markup.table(frame, "Numbers")
    cells = [re.sub("<.*?>", "", cell) for cell in re.findall("<td.*?</td>", text)]
    assert cells[:6] == ["0.001", "102.0", "0.00", "4.26 × 10⁻⁸", "yes", "–"]
    assert cells[6:] == ["50", "70.6", "12.35", "0.001", "no", "a &lt; b"]
    assert "peak frequency (Hz)" in text


def test_repeated_entries_are_printed_once():
    frame = pd.DataFrame({"joint": ["a", "a", "b"], "force_N": [1.0, 2.0, 1.0]})
    text = markup.table(frame, "Groups", groups=["joint"])
    assert [re.sub("<.*?>", "", cell) for cell in re.findall("<td.*?</td>", text)] == [
        *("a", "1"),
        *("", "2"),
        *("b", "1"),
    ]


def test_a_case_of_which_nothing_was_solved_has_its_pages(files):
    def fail(frame):
        numbers = frame.select_dtypes("float").columns.difference(["force_N"])
        lost = frame.assign(**dict.fromkeys(numbers, np.nan), complete=False, turning_points=0)
        return lost.assign(reason="no solution found at the start of the window")

    edit(files, "accuracy_mine_free-4", fail)
    edit(files, "times_mine_free-4", lambda frame: frame.assign(complete=False))
    page = write(files)
    reference = figure(page, "response_mine_free-4_node-to-node_linear_resonance=1")
    assert "Broken off at 0.001, 50 N: no solution found at the start of the window." in reference
    assert not re.search(r"\bnan\b", re.sub("<svg.*?</svg>", "", page, flags=re.DOTALL))
    assert overview_of(files)[1][4:8] == ["–"] * 4
