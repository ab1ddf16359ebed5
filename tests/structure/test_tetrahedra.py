"""A half lap in 10-node tetrahedra, from its deck: the same joint in other elements."""

import numpy as np
import pytest
from deck_of_assembly import deck_of_finer, tetrahedra_of

from boltjoint.config.deck import Deck
from boltjoint.structure.elements.kinds import KINDS
from boltjoint.structure.makers.deck.structure import model_of_deck
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload


def test_tetrahedra_fill_bricks_and_share_their_faces():
    # two bricks side by side, numbered so that the smallest nodes lie anywhere
    place = np.array([[x, y, z] for z in range(2) for y in range(2) for x in range(3)], float)
    corner = [0, 1, 4, 3, 6, 7, 10, 9]
    for seed in range(20):
        number = np.random.default_rng(seed).permutation(len(place))
        nodes = place[np.argsort(number)]
        bricks = np.array([number[corner], number[np.array(corner) + 1]])
        tetrahedra = tetrahedra_of(bricks)
        edges = nodes[tetrahedra[:, 1:]] - nodes[tetrahedra[:, :1]]
        volume = np.linalg.det(edges) / 6
        assert np.allclose(volume, 1 / 6)
        faces = np.sort(tetrahedra[:, np.array(KINDS["C3D4"].corners_of_faces)], axis=-1)
        _, count = np.unique(faces.reshape(-1, 3), axis=0, return_counts=True)
        # two triangles of each of ten faces outside, all others of two tetrahedra
        assert (count == 1).sum() == 20
        assert count.max() == 2


@pytest.fixture(scope="module")
def in_tetrahedra(tiny, tmp_path_factory):
    folder = tmp_path_factory.mktemp("tetrahedra")
    (folder / "lap.inp").write_text(deck_of_finer(tiny, 8e3, tetrahedra=True))
    return Deck.model_validate(
        {
            "type": "deck",
            "file": "lap.inp",
            "units": {"length": "mm", "mass": "t"},
            "contact": [{"name": "lap", "surfaces": ["lap_a", "lap_b"]}],
        }
    ).in_folder(folder)


def test_a_lap_in_tetrahedra_is_the_one_in_bricks(tiny, in_tetrahedra):
    structure, built = (
        model_of_deck(in_tetrahedra, in_tetrahedra.folder).structure,
        structure_of(tiny),
    )
    # a point on each of two triangles that a brick has in the contact
    assert len(structure.contact) == 2 * 54
    assert structure.contact.area.sum() == pytest.approx(built.contact.area.sum(), rel=1e-12)
    preload, of_bricks = (apply_preload(each, 8e3) for each in (structure, built))
    assert float(preload["normal_load"].sum()) == pytest.approx(16e3, rel=1e-12)
    # softer, as 10-node tetrahedra know more motions than bricks with the same corners
    shortening = (preload["shank_shortening"] / of_bricks["shank_shortening"]).to_numpy()
    assert np.all((0.95 < shortening) & (shortening < 1.05))
    frequency = [
        float(find_modes(each, "free-1")["natural_frequency"][0]) for each in (structure, built)
    ]
    assert 0.99 * frequency[1] < frequency[0] < frequency[1]
