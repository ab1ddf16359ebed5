"""The drawing of a half lap's keys: all are in it, where the mesh is as they say."""

import xml.etree.ElementTree as ET
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from pydantic import BaseModel

from boltjoint.config.bolts import Bolts, Washer
from boltjoint.config.lap_joint import Bar, LapJoint, Mesh
from boltjoint.config.strict_yaml import read_mapping

ROOT = Path(__file__).parents[2]
FIGURE = ROOT / "docs/figures/mesh_keys.svg"
#: of nodes around a circle, which are corners of a polygon of the same area
OUTSIDE_CIRCLE = 3e-3
#: other numbers of elements than those of the assemblies that are drawn, one by one; each keeps
#: the defaults of the others
OTHERS = {
    "ring_cells_across_width": 8,
    "ring_cells_along_bar": 12,
    "rings_under_head": 3,
    "rings_head_to_cell_edge": 7,
    "columns_between_bolt_cells": 3,
    "columns_at_each_lap_end": 4,
    "layers_per_half_height": 3,
    "rings_in_shank": 1,
    "layers_in_head": 3,
    "rings_head_to_washer_edge": 2,
    "layers_in_washer": 2,
}
#: other lengths: in the mesh all that is measured follows them
OTHER_LENGTHS = {
    "bar": {"width_mm": 22.0, "height_mm": 18.0, "free_length_mm": [130.0, 120.0], "lap_mm": 114.0},
    "bolts": {
        "pitch_mm": 31.0,
        "shank_diameter_mm": 7.5,
        "hole_diameter_mm": 8.8,
        "head_diameter_mm": 12.5,
        "head_height_mm": 5.0,
        "nut_height_mm": 6.0,
    },
    "mesh": {"bolt_cell_length_mm": 24.0, "element_length_free_mm": 5.0},
}
OF_WASHER = {"thickness_mm": 2.0, "diameter_mm": 15.0, "hole_diameter_mm": 8.2}


@pytest.fixture(autouse=True)
def scripts(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    monkeypatch.syspath_prepend(str(ROOT / "tests/report"))
    plt.switch_backend("agg")
    yield
    plt.close("all")


def texts(path):
    """Texts of an SVG file and their attributes, such as their places."""
    return [
        ("".join(each.itertext()), each.attrib)
        for each in ET.parse(path).iter("{http://www.w3.org/2000/svg}text")
    ]


def names(section: type[BaseModel], unit: str = "") -> set[str]:
    return {name for name in section.model_fields if name.endswith(unit)}


def changed(name, mesh=(), **lengths):
    """An assembly that is drawn, with other keys."""
    content = read_mapping(ROOT / f"config/assemblies/{name}.yaml")
    for section, keys in {**lengths, "mesh": lengths.get("mesh", {}) | dict(mesh)}.items():
        content[section] |= keys
    if lengths and "washer" in content["bolts"]:
        content["bolts"]["washer"] |= OF_WASHER
    return LapJoint(**content)


def value(assembly, key):
    """What a key of the drawing says: a length [mm] or a number of elements."""
    path, _, index = key.removesuffix("]").partition("[")
    if path == "bolts.positions_from_lap_start_mm":
        return assembly.bolt_positions_mm[int(index)]
    found = assembly
    for name in path.split("."):
        found = getattr(found, name)
    if found is None:  # by default
        return getattr(assembly, name)
    return found[int(index)] if index else found


def assert_as_in_the_mesh(views, assemblies):
    for view, assembly in zip(views, assemblies, strict=True):
        for dimension in view.dimensions:
            expected = value(assembly, dimension.key)
            if dimension.counts_elements:
                elements = view.cut.elements_between(dimension.begin, dimension.end)
                assert elements == expected, dimension.key
                continue
            relative = OUTSIDE_CIRCLE if "diameter" in dimension.key else 1e-9
            if dimension.key == "mesh.element_length_free_mm":  # approximate
                relative = 0.05
            assert dimension.length == pytest.approx(expected, rel=relative), dimension.key


def numbers_of_elements(views):
    return [
        (dimension.key, view.cut.elements_between(dimension.begin, dimension.end))
        for view in views
        for dimension in view.dimensions
        if dimension.counts_elements
    ]


def views_of_changed(mesh=(), **lengths):
    from mesh_keys_picture import DRAWN
    from mesh_keys_views import views_of

    washers = {"rings_head_to_washer_edge", "layers_in_washer"}
    without = {key: number for key, number in dict(mesh).items() if key not in washers}
    plain = changed(DRAWN[0], without, **lengths)
    with_washers = changed(DRAWN[1], mesh, **lengths)
    return views_of(plain, with_washers), [plain] * 3 + [with_washers]


def test_every_key_of_the_mesh_and_every_length_is_in_the_drawing():
    drawn = {text.removeprefix("⌀ ").partition("[")[0] for text, _ in texts(FIGURE)}
    keys = names(Mesh) | {
        name for section in (Bar, Bolts, Washer) for name in names(section, "_mm")
    }
    assert keys - drawn == set()
    assert names(Mesh) == {*OTHERS, *OTHER_LENGTHS["mesh"]}


def test_dimensions_are_those_of_the_mesh():
    assert_as_in_the_mesh(*views_of_changed())
    assert_as_in_the_mesh(*views_of_changed(**OTHER_LENGTHS))


@pytest.mark.parametrize("key", OTHERS)
def test_a_number_of_elements_acts_where_it_is_drawn_and_nowhere_else(key):
    before, (views, assemblies) = views_of_changed()[0], views_of_changed({key: OTHERS[key]})
    assert_as_in_the_mesh(views, assemblies)
    pairs = zip(numbers_of_elements(before), numbers_of_elements(views), strict=True)
    assert {name for (name, old), (_, new) in pairs if new != old} == {f"mesh.{key}"}


def test_the_drawing_is_that_of_the_script_and_its_texts_are_apart(tmp_path, monkeypatch):
    import mesh_keys_picture
    from text_boxes import faults, text_boxes

    figures = []
    picture = mesh_keys_picture.picture
    monkeypatch.setattr(
        mesh_keys_picture, "picture", lambda views: figures.append(picture(views)) or figures[0]
    )
    mesh_keys_picture.draw(tmp_path / "drawn.svg")
    assert texts(tmp_path / "drawn.svg") == texts(FIGURE)
    (figure,) = figures
    assert faults(figure) == []
    for text, corners in text_boxes(figure):
        within = (corners > 0).all() and (corners < figure.bbox.size).all()
        assert within, f"{text} leaves the picture"
