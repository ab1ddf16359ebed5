"""Tables of natural frequencies, with rigid-body modes of free structures."""

import numpy as np
from examples import coarse_assembly

from boltjoint.config.lap_joint import LapJoint
from boltjoint.structure.makers.half_lap.mesh import build_assembly
from boltjoint.structure.modes import find_modes
from boltjoint.study.tables.structure import tabulate_families, tabulate_frequencies


def test_rigid_body_modes_of_a_free_half_lap_are_counted_alone():
    held = coarse_assembly()
    free = LapJoint.model_validate(held.model_dump() | {"support": "none"})
    assembly = build_assembly(free)
    assert assembly.sizes["clamped"] == 0
    modes = {
        "free": find_modes(assembly, "free-2"),
        "held": find_modes(build_assembly(held), "free-2"),
    }
    table = tabulate_frequencies(modes)
    assert table["bending_mode"].tolist() == [1, 2, 1, 2]
    assert table["rigid_body_modes"].tolist() == [6, 6, 0, 0]
    of_free = table.loc[table["assembly"] == "free", "frequency_Hz"]
    np.testing.assert_array_equal(of_free, modes["free"]["natural_frequency"][6:])
    families = tabulate_families({"free": find_modes(assembly, "all-3")})
    assert families["family"].tolist()[:6] == ["rigid body"] * 6
    assert len(families) == 9
