"""Results that figures are drawn from, and files that pages are written from."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from browsing import open_browser
from figure_parts import FORCES
from page_examples import CASE, NODES, SOURCE, save, write
from small_joint import make_joint, make_preload
from small_study import ASSEMBLY, mesh_of
from text_boxes import readable_figures

from boltjoint import dataset
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.joint.io import joint_to_dataset
from boltjoint.joint.partition import partition_regions
from boltjoint.joint.reduced import fit_reduced_joint
from boltjoint.names import REFERENCE, Basis, Coordinates, JointName
from boltjoint.reproduction.published import Published
from boltjoint.study.artefact_list import Artefact

HEIGHT = 0.01


BOLTED = ASSEMBLY | {
    "bar": {"width_mm": 20, "height_mm": 16, "free_length_mm": [60, 50], "lap_mm": 62},
    "material": {"youngs_modulus_GPa": 200, "poissons_ratio": 0.3, "density_kg_per_m3": 7800},
}


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """A browser without a window; tests that need it are skipped without one."""
    running = open_browser(tmp_path_factory.mktemp("profile"))
    yield running
    running.quit()


@pytest.fixture(autouse=True)
def readable():
    """Texts of all figures that a test draws are apart, and in the picture."""
    with readable_figures() as made:
        yield made


@pytest.fixture(scope="module")
def assembly():
    """Two plates of 6 x 2 elements on each other, in contact all over."""
    plan = np.stack(np.meshgrid(np.linspace(0, 0.06, 7), [-0.01, 0, 0.01], indexing="ij"), -1)
    plan = plan.reshape(-1, 2)
    quad = np.array(
        [[3 * i + j, 3 * i + 3 + j, 3 * i + 4 + j, 3 * i + 1 + j] for i in range(6) for j in (0, 1)]
    )
    levels = (-HEIGHT, 0, 0, HEIGHT)
    coordinate = np.concatenate([np.c_[plan, np.full(21, z)] for z in levels])
    bar_a, bar_b = (np.c_[quad + 42 * bar, quad + 42 * bar + 21] for bar in (0, 1))
    pair_node = np.c_[np.arange(21, 42), np.arange(42, 63)]
    area = np.bincount(quad.ravel(), minlength=21) * 1e-4 / 4
    return xr.Dataset(
        {
            "coordinate": (("node", "axis"), coordinate),
            "connectivity": (("element", "corner"), np.concatenate([bar_a, bar_b])),
            "part": ("element", np.repeat([0, 1], 12)),
            "pair_node": (("pair", "side"), pair_node),
            "position": (("pair", "axis"), coordinate[21:42]),
            "area": ("pair", area),
        },
        coords={"axis": ["x", "y", "z"]},
    )


@pytest.fixture(scope="module")
def modes(assembly):
    x = assembly["coordinate"].sel(axis="x").to_numpy()
    shape = np.zeros((x.size, 3, 2))
    shape[:, 2] = np.c_[x**2, x**3 - 0.03 * x**2]
    return xr.Dataset(
        {
            "mode_shape": (("node", "axis", "mode"), shape),
            "natural_frequency": ("mode", [70.62, 360.59]),
        },
        coords={"axis": ["x", "y", "z"]},
    )


@pytest.fixture(scope="module")
def preload(assembly):
    load = np.clip(500 - 2e4 * assembly["position"].sel(axis="x"), 0, None)
    return xr.Dataset(
        {
            "normal_load": load.drop_vars("axis"),
            "gap": ("pair", np.where(load > 0, 0, 1e-6)),
            "position": assembly["position"],
        }
    )


@pytest.fixture(scope="module")
def bolted():
    """Two bars and two bolts, coarsely meshed."""
    return mesh_of(BOLTED)


@pytest.fixture(scope="module")
def regions():
    nodes = make_joint()
    return partition_regions(nodes, make_preload(nodes), 3)


@pytest.fixture(scope="module")
def variable(assembly):
    """A joint under variable normal load on all pairs of the small assembly, some of them open."""
    position = assembly["position"].to_numpy()
    joint = make_joint(len(position), law="variable")
    return replace(joint, position=position, element_position=position)


@pytest.fixture(scope="module")
def variable_response(variable):
    return solve_response(variable, FORCES, damping=0.01)


@pytest.fixture(scope="module")
def reduced(regions):
    fitted, fit = fit_reduced_joint(regions, 2, starts=2)
    return joint_to_dataset(fitted).merge(fit)


@pytest.fixture(scope="module")
def reference():
    return solve_response(make_joint(), FORCES, damping=0.01)


@pytest.fixture(scope="module")
def response(regions):
    return solve_response(regions, FORCES, damping=0.01)


@pytest.fixture
def artefacts(tmp_path, monkeypatch):
    """Figures and tables of a case ``mine``, with one figure that no page expects."""
    monkeypatch.chdir(tmp_path)
    regions, few = JointName("regions=6"), JointName("regions=6/elements=4")
    of_case = {"case": "mine", "basis": Basis("free-4")}
    linear = {"coordinates": REFERENCE[1], "resonance": 1}
    figures = [
        Artefact(
            "response",
            "figure",
            **of_case,
            joint=joint,
            coordinates=Coordinates(coordinates),
            resonance=resonance,
        )
        for resonance, joints in {1: (REFERENCE[0], regions, few), 2: (REFERENCE[0],)}.items()
        for joint in joints
        for coordinates in ("linear", "rdnm-1")
    ]
    figures += [
        Artefact("regions", "figure", **of_case, joint=regions),
        Artefact("loops", "figure", **of_case, joint=few),
        Artefact("states", "figure", **of_case, joint=REFERENCE[0], **linear),
        Artefact("bases", "figure", **of_case),
    ]
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
        response_harmonics=1,
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
        folded_from_converged_Hz=np.where(folded, 71.5, np.nan),
        folded_to_converged_Hz=np.where(folded, 72.75, np.nan),
        largest_multiplier=np.where(folded, 1.25, np.nan),
        stability_harmonics=np.where(folded, 15, 0),
        isolated_branch=None,
        residual_in_time=1e-7,
        worst_in_time_Hz=70.5,
        reason=np.where(broken, "the branch would turn back", None),
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
    of_regions = pd.DataFrame({"region": [1, 2], "elements": [5, 6]})
    tables = {
        Artefact("accuracy", "table", **of_case): accuracy,
        Artefact("times", "table", **of_case): times,
        Artefact("elements", "table", **of_case, joint=few): elements,
        Artefact("regions", "table", **of_case, joint=regions): of_regions,
    }
    joint = xr.Dataset(
        {
            "slip_force": ("element", np.ones(1178), {"units": "N"}),
            "resonance_range": (
                ("resonance", "bound"),
                [[70.6, 102.0], [350.0, 420.0]],
                {"units": "Hz"},
            ),
        }
    )
    dataset.save(joint, NODES.path)
    return [*map(save, figures), *(save(table, frame) for table, frame in tables.items())]


@pytest.fixture
def page(artefacts):
    return write(artefacts)
