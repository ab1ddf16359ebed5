"""A half lap that is turned in space, with no symmetry told, has all that it has at rest."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse
from scipy.spatial.transform import Rotation

from boltjoint import solve_branch
from boltjoint.dynamics.reduction.hyper_reduction import weigh_pairs
from boltjoint.friction.registry import LAWS
from boltjoint.joint.node_to_node import connect_pairs
from boltjoint.joint.partition import partition_regions
from boltjoint.structure.adapted_basis.candidates import find_candidates
from boltjoint.structure.geometry import Geometry
from boltjoint.structure.model import Row
from boltjoint.structure.modes import find_modes
from boltjoint.structure.patterns import stuck_patterns
from boltjoint.structure.preload import apply_preload

ANGLES, SHIFT = [0.7, -1.1, 2.3], np.array([0.4, -0.2, 1.3])
CONTACT = {
    "constant": {"tangential_stiffness": 2e7, "friction_coefficient": 0.1},
    "variable": {
        "tangential_stiffness": 2e7,
        "friction_coefficient": 0.1,
        "normal_stiffness": 3e7,
    },
    "uncoupled-constant": {"tangential_stiffness": 2e7, "friction_coefficient": 0.1},
}
BANDS = ("equal-load", "equal-middle-load", "inner-outer")


def turned(structure):
    """The structure turned about all axes and moved; its unknowns follow x, y, z of space."""
    R = Rotation.from_euler("xyz", ANGLES).as_matrix()
    nodes = (structure.dofs - len(structure.bolts)) // 3
    blocks = [sparse.kron(sparse.eye_array(nodes), R), sparse.eye_array(len(structure.bolts))]
    Q = sparse.block_diag(blocks, format="csc")
    contact, geometry = structure.contact, structure.geometry
    of_nodes = sparse.kron(sparse.eye_array(len(geometry.node)), R, format="csc")
    return replace(
        structure,
        stiffness=(Q @ structure.stiffness @ Q.T).tocsc(),
        mass=(Q @ structure.mass @ Q.T).tocsc(),
        contact=replace(
            contact,
            relative=(contact.relative @ Q.T).tocsr(),
            position=contact.position @ R.T + SHIFT,
            frame=contact.frame @ R.T,
        ),
        bolts=tuple(
            replace(
                bolt, load=Q @ bolt.load, axis=R @ bolt.axis, position=R @ bolt.position + SHIFT
            )
            for bolt in structure.bolts
        ),
        inputs={name: Row(Q @ each.row) for name, each in structure.inputs.items()},
        outputs={name: Row(Q @ each.row) for name, each in structure.outputs.items()},
        support=R @ structure.support @ Q.T,
        geometry=Geometry(
            geometry.node @ R.T + SHIFT,
            (of_nodes @ geometry.displacement @ Q.T).tocsc(),
            geometry.cell,
            geometry.part,
        ),
    )


class Solved:
    """Preload, modes and joints of a structure."""

    def __init__(self, structure):
        self.structure = structure
        self.preload = apply_preload(structure, 8e3)
        self.modes = find_modes(structure, "all-8")
        self.bending = find_modes(structure, "free-5")

    def joint(self, law, modes=None):
        modes = self.modes if modes is None else modes
        return connect_pairs(modes, self.preload, LAWS[law], **CONTACT[law])


@pytest.fixture(scope="module")
def both(structure):
    """At rest and turned."""
    # the families of a half lap are those of its axes
    plain = replace(structure, symmetry=None, maker="")
    return Solved(plain), Solved(turned(plain))


def test_loads_and_modes_do_not_turn(both):
    rest, other = both
    # of one solution with other rounding: the tolerance of the search is 1e-10 of the preload
    largest = rest.preload["normal_load"].to_numpy().max()
    for name in ("normal_load", "friction_force"):
        np.testing.assert_allclose(
            other.preload[name], rest.preload[name], rtol=0, atol=1e-8 * largest
        )
    np.testing.assert_allclose(
        other.modes["natural_frequency"], rest.modes["natural_frequency"], rtol=1e-8
    )
    relative = [each.modes["relative_mode"].transpose("pair", "axis", "mode") for each in both]
    # lateral modes do not move the output point: their sign is any
    moved = abs(rest.modes["response_mode"].to_numpy()) > 1e-6
    assert np.count_nonzero(moved) >= 4
    scale = abs(relative[0].to_numpy()).max()
    one, two = (each.to_numpy()[..., moved] for each in relative)
    np.testing.assert_allclose(two, one, rtol=0, atol=1e-7 * scale)


@pytest.mark.parametrize("law", CONTACT)
@pytest.mark.parametrize("division", BANDS)
def test_regions_do_not_turn(both, law, division):
    regions = [partition_regions(each.joint(law), each.preload, 4, division) for each in both]
    one, two = (each.law.point_of_element for each in regions)
    np.testing.assert_array_equal(two, one)
    assert np.unique(one).size == 4
    np.testing.assert_allclose(
        abs(regions[1].tangential_mode), abs(regions[0].tangential_mode), rtol=0, atol=1e-6
    )


@pytest.mark.parametrize("law", CONTACT)
@pytest.mark.parametrize("count", [4, 9])
def test_clusters_do_not_turn(both, law, count):
    # in lateral motion rounding tells which of two mirror images slips first
    joints = [(each.joint(law, each.bending), each.preload) for each in both]
    one, two = (
        partition_regions(*each, count, "clusters", resonances=2).law.point_of_element
        for each in joints
    )
    np.testing.assert_array_equal(two, one)


def test_lines_along_a_region_do_not_turn(both):
    one, two = (
        partition_regions(each.joint("constant"), each.preload, 2, motion="linear") for each in both
    )
    np.testing.assert_allclose(abs(two.tangential_mode), abs(one.tangential_mode), atol=1e-6)


def test_weighted_pairs_and_responses_do_not_turn(both):
    found = []
    for each in both:
        joint = each.joint("constant")
        weighted, fit = weigh_pairs(joint, [20.0], 2e-3, count=12)
        branch = solve_branch(joint, 20.0, damping=2e-3)
        peak = [branch.peak_frequency, branch.peak_amplitude]
        # rounding tells which of two mirror images is chosen
        from_middle = abs(weighted.places.place - joint.places.place.mean(axis=0)).round(9)
        order = np.lexsort(from_middle.T)
        found.append((from_middle[order], fit["weight"].to_numpy()[order], peak))
    (place, weight, peak), (other_place, other_weight, other_peak) = found
    np.testing.assert_allclose(other_place, place, atol=1e-9)
    np.testing.assert_allclose(other_weight, weight, rtol=1e-4)
    np.testing.assert_allclose(other_peak, peak, rtol=1e-7)


def test_patterns_and_candidates_do_not_turn(both):
    # between the rings of nodes
    radii = 0.0075, 0.0051
    patterns = [stuck_patterns(each.structure, each.preload, radii) for each in both]
    assert patterns[0].keys() == patterns[1].keys()
    for name, stuck in patterns[0].items():
        assert 0 < np.count_nonzero(stuck)
        np.testing.assert_array_equal(patterns[1][name], stuck, err_msg=name)
    few = [find_candidates(each.structure, each.preload, 4) for each in both]
    np.testing.assert_allclose(few[1].to_bolts, few[0].to_bolts, rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.diff(few[1].along), np.diff(few[0].along), rtol=0, atol=1e-12)
