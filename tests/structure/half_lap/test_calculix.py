"""CalculiX: what the decks say, what is read back, and, where it is installed, what it finds."""

import shutil

import numpy as np
import pandas as pd
import pytest
from examples import COARSE, brick_bar
from small_study import CASE, ROOT, SETTINGS, snakemake, write
from test_bolts import ALUMINIUM, BRASS, STEEL, WIDE, bolted

from boltjoint.structure.calculix_program import run
from boltjoint.structure.elasticity import assemble, smallest_jacobian
from boltjoint.structure.makers.half_lap.calculix import (
    read_modes,
    read_preload,
    write_modes_deck,
    write_preload_deck,
)
from boltjoint.structure.makers.half_lap.comparison_with_calculix import compare_with_calculix
from boltjoint.structure.makers.half_lap.mesh import build_assembly
from boltjoint.structure.makers.half_lap.parts import element_materials
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

# corners of the faces S1 to S6, from the manual (*SURFACE), counted from 1
FACES = [[1, 2, 3, 4], [5, 8, 7, 6], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 8, 4], [4, 8, 5, 1]]


class Deck:
    """The blocks of a deck: keyword line and data lines."""

    def __init__(self, path):
        self.lines = path.read_text().splitlines()
        self.blocks = []
        for line in self.lines:
            if line.startswith("*"):
                self.blocks.append((line, []))
            else:
                self.blocks[-1][1].append([part for part in line.split(",") if part.strip()])

    def data(self, keyword):
        return [row for head, rows in self.blocks if head.startswith(keyword) for row in rows]

    def numbers(self, keyword):
        return np.array(self.data(keyword), dtype=float)

    @property
    def coordinate(self):
        rows = self.numbers("*NODE, NSET=ALL")
        coordinate = np.full((int(rows[:, 0].max()) + 1, 3), np.nan)
        coordinate[rows[:, 0].astype(int)] = rows[:, 1:]
        return coordinate

    @property
    def connectivity(self):
        rows = self.numbers("*ELEMENT").astype(int)
        np.testing.assert_array_equal(rows[:, 0], np.arange(len(rows)) + 1)
        return rows[:, 1:]

    def faces(self, name):
        """Corners of the faces of a surface, and the elements they belong to."""
        rows = self.data(f"*SURFACE, NAME={name}")
        element = np.array([int(row[0]) - 1 for row in rows])
        face = np.array([FACES[int(row[1].strip()[1:]) - 1] for row in rows]) - 1
        return self.connectivity[element[:, None], face], element


@pytest.fixture(scope="module")
def of_modes(assembly, tmp_path_factory):
    path = tmp_path_factory.mktemp("decks") / "new folder" / "modes.inp"
    write_modes_deck(assembly, 11, path)
    return Deck(path)


@pytest.fixture(scope="module")
def of_preload(assembly, tmp_path_factory):
    path = tmp_path_factory.mktemp("decks") / "new folder" / "preload.inp"
    write_preload_deck(assembly, 8e3, path)
    return Deck(path)


@pytest.fixture(params=["of_modes", "of_preload"])
def deck(request):
    return request.getfixturevalue(request.param)


def volumes(corners):
    """Of hexahedra, from six tetrahedra around a diagonal; negative where inside out."""
    tetrahedra = [
        [0, 1, 2, 6],
        [0, 2, 3, 6],
        [0, 3, 7, 6],
        [0, 7, 4, 6],
        [0, 4, 5, 6],
        [0, 5, 1, 6],
    ]
    p = corners[:, tetrahedra]
    return np.linalg.det(p[:, :, 1:] - p[:, :, :1]).sum(axis=1) / 6


def test_nodes_and_elements_are_those_of_the_mesh(assembly, deck):
    assert len(deck.connectivity) == assembly.sizes["element"]
    across = assembly.sizes["section_pair"]
    assert len(deck.data("*NODE, NSET=ALL")) == assembly.sizes["node"] - across
    # no node is left over that nothing holds, and none is missing
    used = np.unique(deck.connectivity)
    np.testing.assert_array_equal(used, np.flatnonzero(~np.isnan(deck.coordinate[:, 0])))
    np.testing.assert_allclose(
        deck.coordinate[deck.connectivity],
        assembly["coordinate"].to_numpy()[assembly["connectivity"].to_numpy()],
        atol=1e-14,
    )


def test_hexahedra_are_not_inside_out(assembly, deck):
    volume = volumes(deck.coordinate[deck.connectivity])
    assert volume.min() > 0
    connectivity = assembly["connectivity"].to_numpy()
    np.testing.assert_allclose(
        volume, volumes(assembly["coordinate"].to_numpy()[connectivity]), rtol=1e-9
    )
    # nodes across a closed section have no place of their own
    used, corner = np.unique(deck.connectivity, return_inverse=True)
    connectivity = corner.reshape(deck.connectivity.shape)
    assert smallest_jacobian(deck.coordinate[used], connectivity).min() > 0


def test_sections_are_closed(assembly, deck):
    nut_side, head_side = assembly["section_node"].to_numpy().T
    used = np.unique(deck.connectivity) - 1
    assert np.isin(nut_side, used).all() and not np.isin(head_side, used).any()
    # now elements of both sides have them
    number = np.bincount(deck.connectivity.ravel())[nut_side + 1]
    before = np.bincount(assembly["connectivity"].to_numpy().ravel())[nut_side]
    np.testing.assert_array_equal(number, 2 * before)


def test_fields_are_as_short_as_calculix_reads(deck):
    fields = [part for line in deck.lines if not line.startswith("*") for part in line.split(",")]
    assert max(len(field.strip()) for field in fields) <= 20
    assert max(map(len, deck.lines)) <= 132


def test_material_and_clamp(assembly, deck):
    elastic = [assembly["youngs_modulus"].item(), assembly["poissons_ratio"].item()]
    np.testing.assert_allclose(deck.numbers("*ELASTIC")[0], elastic)
    assert deck.numbers("*DENSITY")[0, 0] == pytest.approx(assembly["density"].item())
    clamped = deck.numbers("*NSET, NSET=CLAMPED")[:, 0].astype(int)
    assert len(clamped) == assembly.sizes["clamped"]
    np.testing.assert_array_equal(deck.coordinate[clamped, 0], 0.0)
    assert deck.data("*BOUNDARY") == [["CLAMPED", " 1", " 3"]]


def test_every_element_has_its_material(tmp_path):
    own = {"material": STEEL, "washer": WIDE | {"material": BRASS}}
    built = build_assembly(bolted(own, bars=ALUMINIUM))
    write_modes_deck(built, 1, tmp_path / "modes.inp")
    deck = Deck(tmp_path / "modes.inp")
    assert len(deck.connectivity) == built.sizes["element"]
    name = ""
    materials, found = {}, np.full((built.sizes["element"], 3), np.nan)
    for head, rows in deck.blocks:
        match head.split(","):
            case ["*MATERIAL", named]:
                name = named.removeprefix(" NAME=")
            case ["*ELASTIC" | "*DENSITY"]:
                materials.setdefault(name, []).extend(map(float, rows[0]))
            case ["*SOLID SECTION", elements, named]:
                members = deck.numbers(f"*ELSET,{elements}")[:, 0].astype(int) - 1
                # none twice
                assert np.isnan(found[members]).all()
                found[members] = materials[named.removeprefix(" MATERIAL=")]
    assert len(materials) == 3
    np.testing.assert_allclose(found, np.column_stack(element_materials(built)), rtol=1e-12)


def test_modes_are_asked_for_without_contact(of_modes):
    assert of_modes.data("*FREQUENCY") == [["11"]]
    keywords = " ".join(head for head, _ in of_modes.blocks)
    assert "CONTACT" not in keywords and "TENSION" not in keywords


@pytest.mark.parametrize(("name", "side", "upward"), [("BAR_A", "A", 1), ("BAR_B", "B", -1)])
def test_surfaces_that_touch(assembly, of_preload, name, side, upward):
    corners, _ = of_preload.faces(name)
    node = assembly["pair_node"].sel(side=side).to_numpy()
    np.testing.assert_array_equal(np.unique(corners), np.sort(node) + 1)
    printed = of_preload.numbers(f"*NSET, NSET=SIDE_{side}")[:, 0]
    np.testing.assert_array_equal(printed, node + 1)
    point = of_preload.coordinate[corners]
    # the manual's faces are numbered to have their normals inward
    normal = -np.cross(point[:, 2] - point[:, 0], point[:, 3] - point[:, 1]) / 2
    np.testing.assert_allclose(normal[:, :2], 0, atol=1e-18)
    assert (upward * normal[:, 2]).min() > 0
    assert abs(normal[:, 2]).sum() == pytest.approx(float(assembly["area"].sum()))


def test_nodes_of_bar_a_meet_faces_of_bar_b_with_the_law_of_the_assembly(assembly, of_preload):
    assert of_preload.data("*CONTACT PAIR") == [["BAR_A", " BAR_B"]]
    slope, tension = of_preload.numbers("*SURFACE BEHAVIOR")[0]
    penalty = assembly["contact_penalty"].item()
    assert slope == penalty
    # however far the surfaces open, they pull less than a thousandth of the mean pressure
    assert 0 < tension < 1e-3 * 8e3 * assembly.sizes["bolt"] / float(assembly["area"].sum())
    friction = [assembly["friction_coefficient"].item(), penalty]
    np.testing.assert_allclose(of_preload.numbers("*FRICTION")[0], friction)


def test_no_friction_is_no_card(assembly, tmp_path):
    smooth = assembly.assign(friction_coefficient=0 * assembly["friction_coefficient"])
    write_preload_deck(smooth, 8e3, tmp_path / "smooth.inp")
    assert not Deck(tmp_path / "smooth.inp").data("*FRICTION")


def test_bolts_are_tightened_and_not_pushed_apart(assembly, of_preload):
    for b in range(assembly.sizes["bolt"]):
        corners, element = of_preload.faces(f"SECTION_{b + 1}")
        here = assembly["section_node"].isel(section_pair=assembly["section_bolt"] == b)
        nodes = np.sort(here.sel(section_side="nut").to_numpy()) + 1
        np.testing.assert_array_equal(np.unique(corners), nodes)
        # all elements of the surface are on the nut's side, and of no other have corners there:
        # CalculiX gives new nodes to these elements, and to these only
        inside = of_preload.coordinate[of_preload.connectivity[element]].mean(axis=1)
        assert inside[:, 2].max() < 0
        below = of_preload.coordinate[of_preload.connectivity].mean(axis=1)[:, 2] < 0
        touching = np.isin(of_preload.connectivity, nodes).any(axis=1) & below
        np.testing.assert_array_equal(np.sort(element), np.flatnonzero(touching))
    # away from the elements of the surface, which makes a positive force tension
    normal = of_preload.numbers("*PRE-TENSION SECTION")
    np.testing.assert_array_equal(normal, [[0, 0, 1]] * assembly.sizes["bolt"])


def test_every_bolt_has_its_force_on_a_node_of_its_own(assembly, of_preload):
    label = of_preload.numbers("*NODE, NSET=TIGHTENING")[:, 0].astype(int)
    assert len(set(label)) == assembly.sizes["bolt"]
    assert label.min() > of_preload.connectivity.max()
    heads = [head for head, _ in of_preload.blocks if head.startswith("*PRE-TENSION")]
    assert [int(head.split("NODE=")[1]) for head in heads] == label.tolist()
    load = of_preload.numbers("*CLOAD")
    np.testing.assert_array_equal(load, [[one, 1, 8e3] for one in label])


def test_decks_repeat_to_the_byte(assembly, of_preload, tmp_path):
    write_preload_deck(assembly, 8e3, tmp_path / "again.inp")
    assert (tmp_path / "again.inp").read_text().splitlines() == of_preload.lines


def printed(path, *tables):
    """A file as CalculiX prints it."""
    text = ""
    for title, rows in tables:
        lines = [f"{label:10d}" + "".join(f" {x:13.6E}" for x in row) for label, row in rows]
        text += "\n".join(["", title, "", *lines, ""])
    # so Fortran writes an exponent of three digits
    path.write_text(text.replace("E-112", "-112"))
    return path


def test_modes_are_read_by_label(assembly, modes, tmp_path):
    _, head_side = assembly["section_node"].to_numpy().T
    shape = modes["mode_shape"].to_numpy().copy()
    shape[7, 0] = [-9.25e-112, 1e-10, -1e10]
    frequency = modes["natural_frequency"].to_numpy()
    nodes = np.setdiff1d(np.arange(assembly.sizes["node"]), head_side)[::-1]
    title = " displacements (vx,vy,vz) for set ALL and time  0.1000000E+01"
    table = [(m + 1, [0, 0, f, 0]) for m, f in enumerate(frequency)]
    blocks = [(title, [(n + 1, shape[n, :, m]) for n in nodes]) for m in range(3)]
    path = printed(
        tmp_path / "modes.dat", ("MODE NO\n  (RAD/TIME)   (CYCLES/TIME)", table), *blocks
    )
    found = read_modes(assembly, path)
    np.testing.assert_allclose(found["natural_frequency"], frequency, rtol=1e-6)
    np.testing.assert_allclose(found["mode_shape"], shape, rtol=1e-6, atol=1e-120)


def test_contact_is_read_with_the_area_of_calculix(assembly, preload, tmp_path):
    a, b = assembly["pair_node"].to_numpy().T + 1
    gap = preload["gap"].to_numpy()
    pressure, tangential = np.linspace(-1e3, 4e7, len(a)), np.linspace(1e5, 2e6, len(a))
    path = printed(
        tmp_path / "preload.dat",
        (" displacements for set SIDE_A and", [(n, [1, 1, 0.0]) for n in a]),
        (
            " displacements for set SIDE_B and",
            [(n, [1, 1, g]) for n, g in zip(b, gap, strict=True)],
        ),
        (" displacements for set TIGHTENING and", [(9001, [3e-5, 0, 0]), (9002, [4e-5, 0, 0])]),
        # open pairs that are far apart are left out
        (
            " contact stress (slave node)",
            [(a[i], [pressure[i], tangential[i], tangential[i] / 2]) for i in range(1, len(a))],
        ),
    )
    found = read_preload(assembly, path)
    np.testing.assert_allclose(found["gap"], gap, rtol=1e-6)
    np.testing.assert_allclose(found["shank_shortening"], [3e-5, 4e-5])
    area = found["normal_load"].to_numpy()[1:] / pressure[1:]
    assert found["normal_load"][0] == 0
    # nodal areas add up to the surface, whichever way its faces are shared out
    rest = float(assembly["area"][1:].sum())
    assert area.sum() == pytest.approx(rest, rel=1e-3)
    np.testing.assert_allclose(area, assembly["area"][1:], rtol=0.1)
    np.testing.assert_allclose(found["friction_force"][1:, 0], tangential[1:] * area, rtol=1e-5)
    np.testing.assert_allclose(
        found["friction_force"][1:, 1], -tangential[1:] * area / 2, rtol=1e-5
    )


def test_what_was_not_printed_is_named(assembly, tmp_path):
    path = printed(tmp_path / "modes.dat", ("CYCLES/TIME", [(1, [0, 0, 1, 0])]))
    with pytest.raises(ValueError, match=r"modes\.dat: CalculiX printed no 'set ALL'"):
        read_modes(assembly, path)


def changed(modes, frequency=1.0, shape=1.0):
    """The modes as another program may give them: among others, in another order, other signs."""
    other = np.random.default_rng(3).standard_normal((*modes["mode_shape"].shape[:2], 1))
    shapes = np.concatenate([other, -shape * modes["mode_shape"].to_numpy()[:, :, ::-1]], axis=2)
    frequencies = np.append(1.0, frequency * modes["natural_frequency"].to_numpy()[::-1])
    new = modes[["natural_frequency", "mode_shape"]].isel(mode=[0, 0, 1, 2])
    return new.assign(
        natural_frequency=("mode", frequencies), mode_shape=(("node", "axis", "mode"), shapes)
    )


def test_modes_are_matched_by_shape(assembly, modes, preload):
    table = compare_with_calculix(assembly, modes, preload, changed(modes, 1.002), preload)
    table = table.set_index("quantity")
    for mode, frequency in enumerate(modes["natural_frequency"].to_numpy()):
        row = table.loc[f"natural frequency of bending mode {mode + 1}"]
        assert row["calculix"] == pytest.approx(1.002 * frequency)
        assert row["difference_percent"] == pytest.approx(0.2)
        assert row["likeness"] == pytest.approx(1) and row["holds"] is True
    assert not table["holds"].eq(False).any()
    assert table.loc["pairs in contact", "likeness"] == 1
    assert table.loc["normal load of all pairs", "difference_percent"] == 0


def test_what_differs_too_much_is_told(assembly, modes, preload, caplog):
    worse = preload.assign(normal_load=1.002 * preload["normal_load"])
    table = compare_with_calculix(assembly, modes, preload, changed(modes, 1.004), worse)
    broken = table.loc[table["holds"].eq(False), "quantity"].tolist()
    assert broken == [
        *(f"natural frequency of bending mode {mode}" for mode in (1, 2, 3)),
        "normal load of all pairs",
    ]
    assert "normal load of all pairs" in caplog.text

    rolled = preload.assign(normal_load=preload["normal_load"].roll(pair=1))
    other = changed(modes).assign(mode_shape=changed(modes)["mode_shape"].roll(node=7))
    table = compare_with_calculix(assembly, modes, preload, other, rolled).set_index("quantity")
    # the same frequency and the same sum do not make the same mode and the same loads
    assert table.loc["largest normal load of a pair", "holds"] is False
    assert table.loc["natural frequency of bending mode 1", "holds"] is False
    assert table.loc["normal load of all pairs", "holds"] is True


def test_says_that_calculix_is_missing_or_stopped(tmp_path, monkeypatch):
    program = tmp_path / "bin" / "ccx"
    program.parent.mkdir()
    monkeypatch.setenv("PATH", str(program.parent))
    deck, log = tmp_path / "some.inp", tmp_path / "logs" / "some.log"
    with pytest.raises(RuntimeError, match="install CalculiX"):
        run(deck, log)
    program.write_text("#!/bin/sh\necho no convergence\nexit 201\n")
    program.chmod(0o755)
    with pytest.raises(RuntimeError, match=r"could not solve .*some\.inp, see .*some\.log"):
        run(deck, log)
    assert log.read_text() == "no convergence\n"


@pytest.fixture(params=["of one material", "with washers"])
def structure(request, assembly, modes, preload):
    """Assembly, modes and preload, of one material or of three."""
    if request.param == "of one material":
        return assembly, modes, preload
    own = {"material": STEEL, "washer": WIDE | {"material": BRASS, "hole_diameter_mm": 8.4}}
    built = build_assembly(bolted(own, bars=ALUMINIUM))
    return built, find_modes(built, "free-3"), apply_preload(built, 8e3)


@pytest.mark.usefixtures("installed")
def test_calculix_finds_the_same(structure, tmp_path):
    assembly, modes, preload = structure
    deck = tmp_path / "modes" / "calculix.inp"
    write_modes_deck(assembly, modes.sizes["candidate"], deck)
    run(deck, tmp_path / "modes.log")
    other_modes = read_modes(assembly, deck.with_suffix(".dat"))
    deck = tmp_path / "preload" / "calculix.inp"
    write_preload_deck(assembly, 8e3, deck)
    run(deck, tmp_path / "preload.log")
    other_preload = read_preload(assembly, deck.with_suffix(".dat"))

    table = compare_with_calculix(assembly, modes, preload, other_modes, other_preload)
    table = table.set_index("quantity")
    # in a coarse mesh the bricks are less alike than in that of the study, see the test below
    frequencies = table.index.str.startswith("natural frequency")
    assert abs(table.loc[frequencies, "difference_percent"]).max() < 0.5
    assert table.loc[frequencies, "likeness"].min() > 0.99
    assert abs(table.loc["normal load of all pairs", "difference_percent"]) < 0.01
    assert table.loc["largest normal load of a pair", "likeness"] > 0.999
    assert table.loc["largest gap of a pair", "likeness"] > 0.999
    assert table.loc["pairs in contact", "likeness"] > 0.98
    # also its sign, and that the second tangent is turned round
    friction = "friction force of all pairs, without direction"
    assert table.loc[friction, "likeness"] > 0.99
    assert abs(table.loc["mean shortening of the shanks", "difference_percent"]) < 0.5


@pytest.mark.usefixtures("installed")
def test_workflow_asks_runs_and_compares(tmp_path):
    for name in ("workflow", "profiles", "resources"):
        shutil.copytree(ROOT / name, tmp_path / name)
    write(tmp_path / "config/assemblies/three_bolt.yaml", COARSE)
    write(tmp_path / "config/cases/small.yaml", CASE | {"assembly": "three_bolt"})
    write(tmp_path / "config/config.yaml", SETTINGS)
    done = snakemake(tmp_path, "results/verification/three_bolt/calculix.csv")
    assert done.returncode == 0, done.stderr
    table = pd.read_csv(
        tmp_path / "results/verification/three_bolt/calculix.csv",
        index_col="quantity",
        dtype={"holds": str},
    )
    assert table.loc["normal load of all pairs", "boltjoint"] == pytest.approx(2e4)
    assert table.loc["normal load of all pairs", "holds"] == "True"
    assert sum(table.index.str.startswith("natural frequency")) == 4
    under = table.index.str.startswith("frequency under preload")
    assert sum(under) == 6
    # bricks are distorted
    assert abs(table.loc[under, "difference_percent"]).max() < 1
    assert "correlation of the pairs" in (
        tmp_path / "results/verification/three_bolt/calculix.html"
    ).read_text(encoding="utf-8")


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize("distorted", [False, True])
def test_stiffness_differs_for_distorted_bricks_only(tmp_path, distorted):
    coordinate, connectivity = brick_bar(0.03, 0.02, 0.01, (1, 1, 1))
    if distorted:
        coordinate = coordinate + np.random.default_rng(4).uniform(-1e-3, 1e-3, (8, 3))
    K, M = (matrix.toarray() for matrix in assemble(coordinate, connectivity, 2e11, 0.3, 7800.0))
    lines = ["*NODE", *(f"{n}, {x:.12e}, {y:.12e}, {z:.12e}" for n, (x, y, z) in label(coordinate))]
    lines += ["*ELEMENT, TYPE=C3D8I, ELSET=ALL"]
    lines += [", ".join(map(str, [e, *corners + 1])) for e, corners in label(connectivity)]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", "2e11, 0.3", "*DENSITY", "7800."]
    lines += ["*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL"]
    lines += ["*STEP", "*FREQUENCY, SOLVER=MATRIXSTORAGE", "1", "*END STEP"]
    deck = tmp_path / "brick.inp"
    deck.write_text("\n".join(lines) + "\n")
    run(deck, tmp_path / "brick.log")

    # CalculiX has the incompatible modes among its unknowns, and gives them inertia
    K_all, M_all = (stored(deck.with_suffix(suffix), 24 + 9) for suffix in (".sti", ".mas"))
    modes = np.linalg.solve(K_all[24:, 24:], K_all[24:, :24])
    difference = abs(K_all[:24, :24] - K_all[:24, 24:] @ modes - K).max() / abs(K).max()
    np.testing.assert_allclose(M_all[:24, :24], M, atol=1e-12 * abs(M).max())
    assert abs(M_all[24:, 24:]).max() > 0.1 * abs(M).max()
    assert 1e-3 < difference < 0.1 if distorted else difference < 1e-11


def label(rows):
    return enumerate(rows, start=1)


def stored(path, size):
    """A symmetric matrix from its lines of row, column, value."""
    matrix = np.zeros((size, size))
    for line in path.read_text().splitlines():
        row, column, value = line.split()
        matrix[int(row) - 1, int(column) - 1] = matrix[int(column) - 1, int(row) - 1] = value
    return matrix
