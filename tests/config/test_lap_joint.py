"""An assembly: its points, and the contact pairs of its mesh."""

import pytest
from mutations import ROOT

from boltjoint.config.excitation import Point
from boltjoint.config.lap_joint import LapJoint
from boltjoint.config.study import load_study


def test_a_dump_holds_what_results_depend_on():
    assembly = load_study(ROOT).assemblies["three_bolt"]
    renamed = assembly.model_copy(update={"description": "other words"})
    longer = assembly.model_copy(update={"bar": assembly.bar.model_copy(update={"lap_mm": 111.0})})
    assert renamed.model_dump() == assembly.model_dump()
    assert longer.model_dump() != assembly.model_dump()
    assert LapJoint.model_validate(longer.model_dump()).bar.lap_mm == 111.0


def test_keys_that_came_later_are_in_a_dump_where_they_are_given():
    shipped = load_study(ROOT).assemblies["three_bolt"].model_dump()
    later = {
        "bolts": {"material", "washer"},
        "mesh": {"rings_head_to_washer_edge", "layers_in_washer"},
    }
    assert not any(keys & set(shipped[section]) for section, keys in later.items())
    washer = {"thickness_mm": 1.6, "diameter_mm": 16.0}
    given = shipped | {"bolts": shipped["bolts"] | {"washer": washer}}
    given["mesh"] = shipped["mesh"] | {"layers_in_washer": 2}
    dump = LapJoint.model_validate(given).model_dump()
    assert dump["bolts"]["washer"] == washer | {"under": ("head", "nut")}
    assert dump["mesh"]["layers_in_washer"] == 2
    assert LapJoint.model_validate(dump).model_dump() == dump


@pytest.mark.parametrize(
    ("washer", "mesh", "rings", "layers"),
    [
        ({}, {}, 3, 1),  # 1.5 of 3.5 mm between the head and the edge, in 6 rings
        ({"diameter_mm": 13}, {}, 0, 1),
        ({"diameter_mm": 13.01}, {}, 1, 1),
        ({"diameter_mm": 19.99}, {}, 5, 1),
        ({"diameter_mm": 19.99}, {"rings_head_to_cell_edge": 2}, 1, 1),
        ({}, {"rings_head_to_washer_edge": 2, "layers_in_washer": 4}, 2, 4),
        ({"thickness_mm": 8}, {}, 3, 3),  # layers of a head are 2.65 mm thick
        ({"thickness_mm": 1e-9}, {}, 3, 1),
    ],
)
def test_rings_and_layers_of_washers(washer, mesh, rings, layers):
    shipped = load_study(ROOT).assemblies["three_bolt"].model_dump()
    shipped["bolts"]["washer"] = {"thickness_mm": 1.6, "diameter_mm": 16} | washer
    shipped["mesh"] |= mesh
    found = LapJoint.model_validate(shipped)
    assert (found.rings_head_to_washer_edge, found.layers_in_washer) == (rings, layers)


@pytest.mark.parametrize("bolts", [1, 2, 5])
def test_contact_pairs_count_the_nodes_of_the_plane(bolts):
    """Nodes counted cell by cell: each column of nodes once, rings once for each circle."""
    shipped = load_study(ROOT).assemblies["three_bolt"].model_dump()
    shipped["bar"]["lap_mm"] = 30.0 * bolts + 30
    shipped["bolts"]["number"] = bolts
    shipped["bolts"]["pitch_mm"] = None if bolts == 1 else 30.0
    shipped["mesh"] |= {"columns_between_bolt_cells": 3, "columns_at_each_lap_end": 2}
    assembly = LapJoint.model_validate(shipped)

    along, across = 10, 12
    inner_rings = 2 + 6  # the outermost ring of nodes is the edge of the cell
    on_circles = 2 * (along + across) * inner_rings
    on_cell_edges = 2 * (along + 1) + 2 * (across - 1)
    columns = 2 * (bolts - 1) + 2 * 2  # without those that are cell edges
    expected = bolts * (on_circles + on_cell_edges) + columns * (across + 1)
    assert assembly.contact_pairs == expected


def test_points_default_to_the_free_end():
    assembly = load_study(ROOT).assemblies["three_bolt"]
    assert assembly.default_point == Point(x_mm=403.5, y_mm=0, z_mm=10, direction="z")
