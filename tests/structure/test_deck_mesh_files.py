"""Meshes of gmsh and VTU files that a deck includes: the same as lines of the deck."""

import re
import shutil
from pathlib import Path

import meshio
import numpy as np
import pytest
from decks import TWO_CUBES
from test_deck_structure import BOLTED, MILLIMETRES

from boltjoint.config.deck import Deck
from boltjoint.structure.elements.kinds import KINDS
from boltjoint.structure.makers.deck.reader import read_deck
from boltjoint.structure.makers.deck.structure import structure_of_deck

MESHES = Path(__file__).parent / "meshes"
#: written by gmsh 4.15: tetrahedra as text of version 4.1, bricks as binary numbers of version 2.2
WRITTEN_BY_GMSH = {"tetrahedra": "C3D10", "bricks": "C3D20"}

#: what BOLTED says but its mesh, with numbers of reference nodes that the mesh has not
REST = BOLTED[BOLTED.index("*MATERIAL") :].replace("*SURFACE, NAME=HEAD\n2, S2\n", "")
REST = re.sub(r"\b10([01])\b", r"1000\1", REST.replace("*SURFACE, NAME=NUT\n1, S1\n", ""))


def two_cubes(faces=4):
    """The cubes of TWO_CUBES with faces, in parts and surfaces by number."""
    lines = TWO_CUBES.split("*")
    points = np.array([line.split(",") for line in lines[2].splitlines()[1:]], float)[:, 1:]
    bricks = np.arange(16).reshape(2, 8)
    quads = np.array([[4, 5, 6, 7], [8, 11, 10, 9], [12, 13, 14, 15], [0, 3, 2, 1]])[:faces]
    return points, {"hexahedron": bricks, "quad": quads}


@pytest.fixture
def described(tmp_path):
    """The bolted cubes with a mesh of a file."""

    def including(file, surfaces, text=REST):
        (tmp_path / "joint.inp").write_text(f"*INCLUDE, INPUT={file}\n{text}")
        contact = [{"surfaces": surfaces, "penalty_N_per_m3": 1e12}]
        keys = {"units": MILLIMETRES, "contact": contact, "base": "closed"}
        description = Deck.model_validate({"type": "deck", "file": "joint.inp"} | keys)
        return description.in_folder(tmp_path)

    return including


def write_gmsh(path, binary):
    """The two cubes in a file of gmsh, with names of parts and surfaces."""
    points, cells = two_cubes()
    names = ["LOWER", "UPPER", "TOP OF LOWER", "BOTTOM OF UPPER", "HEAD", "NUT"]
    dimensions = [3, 3, 2, 2, 2, 2]
    numbers = range(1, 7)
    groups = [np.array([1, 2]), np.array([3, 4, 5, 6])]
    mesh = meshio.Mesh(
        points,
        cells,
        cell_data={"gmsh:physical": groups, "gmsh:geometrical": groups},
        field_data={
            name: np.array(of)
            for name, of in zip(names, zip(numbers, dimensions, strict=True), strict=True)
        },
    )
    meshio.gmsh.write(path, mesh, fmt_version="2.2", binary=binary)


@pytest.mark.parametrize("binary", [True, False])
def test_a_mesh_of_gmsh_is_that_of_the_deck(described, tmp_path, binary):
    write_gmsh(tmp_path / "cubes.msh", binary)
    surfaces = ["TOP OF LOWER", "BOTTOM OF UPPER"]
    by_mesh = described("cubes.msh", surfaces)
    assert by_mesh.named_files == ("joint.inp", "cubes.msh")
    structure = structure_of_deck(by_mesh, tmp_path)
    (tmp_path / "cubes.inp").write_text(BOLTED)
    other = structure_of_deck(described("cubes.inp", surfaces, ""), tmp_path)
    for name in ("stiffness", "mass"):
        difference = getattr(structure, name) - getattr(other, name)
        assert abs(difference).max() <= 1e-12 * abs(getattr(other, name)).max()
    assert np.allclose(structure.contact.area, other.contact.area, rtol=1e-12)


def test_numbers_of_the_cells_of_a_vtu_file_name_its_groups(described, tmp_path):
    points, cells = two_cubes()
    data = {"part": [np.array([1, 2]), np.array([0, 0, 0, 0])]}
    data["surface"] = [np.array([0, 0]), np.array([1, 2, 3, 4])]
    meshio.vtu.write(tmp_path / "cubes.vtu", meshio.Mesh(points, cells, cell_data=data))
    text = REST.replace("=LOWER", "=part-1").replace("=UPPER", "=part-2")
    text = text.replace("HEAD", "surface-3").replace("NUT", "surface-4")
    structure = structure_of_deck(
        described("cubes.vtu", ["surface-1", "surface-2"], text), tmp_path
    )
    assert structure.contact.area.sum() == pytest.approx(1e-6)


@pytest.mark.parametrize("name", WRITTEN_BY_GMSH)
def test_nodes_of_elements_are_in_the_order_of_decks(described, tmp_path, name):
    shutil.copy(MESHES / f"{name}.msh", tmp_path / "cubes.msh")
    description = described("cubes.msh", ["TOP OF LOWER", "BOTTOM OF UPPER"])
    deck = read_deck(tmp_path, "joint.inp")
    kind = KINDS[WRITTEN_BY_GMSH[name]]
    assert {elements.kind for elements in deck.elements} == {kind.name}
    # edges are straight: nodes are where an affine map has those of the parent element
    parent = np.column_stack([kind.functions.node, np.ones(len(kind.functions.node))])
    for elements in deck.elements:
        for nodes in deck.coordinate[elements.node]:
            _, residual, *_ = np.linalg.lstsq(parent, nodes)
            assert np.all(residual < 1e-20)
    structure = structure_of_deck(description, tmp_path)
    assert structure.contact.area.sum() == pytest.approx(1e-6)
    sides = structure.contact.position[:, 2]
    assert np.allclose(sides, 1e-3)


def test_of_two_solids_at_a_face_that_from_which_it_looks_away(tmp_path):
    points, _ = two_cubes(1)
    joined = np.array([[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 12, 13, 14, 15]])
    for face, expected in (([4, 5, 6, 7], 1), ([4, 7, 6, 5], 2)):
        data = {"part": [np.array([1, 2]), np.array([3])]}
        mesh = meshio.Mesh(points, {"hexahedron": joined, "quad": [face]}, cell_data=data)
        meshio.vtu.write(tmp_path / "cubes.vtu", mesh)
        (tmp_path / "joint.inp").write_text("*INCLUDE, INPUT=cubes.vtu\n")
        (surface,) = read_deck(tmp_path, "joint.inp").surfaces.values()
        (piece,) = surface.pieces
        assert (piece.reference.text, piece.face) == (str(expected), {1: 2, 2: 1}[expected])


def _bad_meshes(folder):
    points, cells = two_cubes()
    yield (
        "pyramids",
        meshio.Mesh(points, {"pyramid": [[0, 1, 2, 3, 4]]}),
        "not read, pyramid: tetra",
    )
    loose = {"hexahedron": cells["hexahedron"], "quad": [[0, 1, 14, 15]]}
    data = {"part": [np.array([1, 2]), np.array([3])]}
    yield "loose", meshio.Mesh(points, loose, cell_data=data), "1 faces of part-3 are on no solid"
    data = {"a,b": [np.array([1, 2])]}
    solids = {"hexahedron": cells["hexahedron"]}
    yield "comma", meshio.Mesh(points, solids, cell_data=data), "group 'a,b-1' must have a name wit"


@pytest.mark.parametrize("place", range(3))
def test_meshes_that_are_refused(tmp_path, place):
    name, mesh, sentence = list(_bad_meshes(tmp_path))[place]
    meshio.vtu.write(tmp_path / f"{name}.vtu", mesh)
    (tmp_path / "joint.inp").write_text(f"*INCLUDE, INPUT={name}.vtu\n")
    with pytest.raises(ValueError, match=sentence) as refused:
        read_deck(tmp_path, "joint.inp")
    assert str(refused.value).startswith(f"{name}.vtu")


@pytest.mark.parametrize("damage", ["half", "letters", "head", "other"])
def test_files_that_are_no_whole_meshes_are_refused_in_a_line(tmp_path, damage):
    (tmp_path / "joint.inp").write_text("*INCLUDE, INPUT=cubes.msh\n")
    content = (MESHES / "tetrahedra.msh").read_bytes()
    damaged = {
        "half": content[: len(content) // 2],
        "letters": content.replace(b"8", b"x"),
        "head": content[:12],
        "other": b"<?xml version='1.0'?>\n<VTKFile type='UnstructuredGrid'>\n<Grid/>",
    }
    (tmp_path / "cubes.msh").write_bytes(damaged[damage])
    with pytest.raises(ValueError, match=r"^cubes\.msh cannot be read as a mesh: \S+.*$"):
        read_deck(tmp_path, "joint.inp")
