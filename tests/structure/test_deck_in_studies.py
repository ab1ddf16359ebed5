"""What a study asks of an assembly from a deck before any job."""

import pytest
from deck_of_assembly import deck_of
from small_study import ASSEMBLY, CASE, SETTINGS, VARIABLE, mesh_of, write

from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError

DECK = {
    "type": "deck",
    "file": "config/joint.inp",
    "units": {"length": "mm", "mass": "t"},
    "elements": [{"kind": "C3D8R", "read_as": "C3D8I"}],
    "contact": [{"name": "lap", "surfaces": ["lap_a", "lap_b"], "points": "nodes"}],
    "points": [{"name": "tip", "near_mm": [122, 0, 10], "direction": "z"}],
}
OF_CASE = {"excitation": {"kind": "inputs", "inputs": [{"name": "tip"}]}, "outputs": ["tip"]}


@pytest.fixture(scope="module")
def text():
    return deck_of(mesh_of(ASSEMBLY), 10e3)


@pytest.fixture
def study(text, tmp_path):
    """A study of the deck of the small half lap, with other keys of its assembly or case."""

    def read(case=(), **changes):
        outputs = {name: case[name] for name in ("outputs",) if name in dict(case)}
        (tmp_path / "config").mkdir(exist_ok=True)
        (tmp_path / "config/joint.inp").write_text(changes.pop("text", text))
        write(tmp_path / "config/assemblies/two_bolt.yaml", DECK | changes)
        write(tmp_path / "config/cases/small.yaml", CASE | dict(case) | OF_CASE | dict(outputs))
        write(tmp_path / "config/config.yaml", SETTINGS)
        return load_study(tmp_path)

    return read


def test_a_deck_has_sizes_bolts_and_files(study):
    assembly = study().assembly("two_bolt")
    mesh = mesh_of(ASSEMBLY)
    assert assembly.size.elements == mesh.sizes["element"]
    assert assembly.contact_pairs == mesh.sizes["pair"]
    assert assembly.bolt_count == 2
    assert assembly.named_files == ("config/joint.inp",)
    assert assembly.surface_names == ("lap",)


@pytest.mark.parametrize(
    ("changes", "case", "line"),
    [
        (
            {"file": "config/none.inp"},
            {},
            "two_bolt.yaml: config/none.inp is missing: the deck lies in",
        ),
        ({"file": "config/joint.txt"}, {}, 'file: "config/joint.txt" must be a file .inp'),
        (
            {"contact": [{"surfaces": ["lap_a", "lap"]}]},
            {},
            "two_bolt.yaml: config/joint.inp has no *SURFACE lap; there are: lap_a, lap_b",
        ),
        ({}, {"preload_ratios": [1, 1, 1]}, "must have 2 ratios, one for each bolt of two_bolt"),
        (
            {"base": "closed"},
            VARIABLE,
            'contact.law: "variable" must be one under constant normal load: modes of two_bolt',
        ),
        ({"text": "*NODE\n1, 2.x\n"}, {}, "config/joint.inp, line 2: *NODE: '2.x' is no number"),
        ({"elements": [{"kind": "C3D8R", "read_as": "S4"}]}, {}, "elements[0].read_as"),
        ({}, {"outputs": ["top"]}, '"top" is no output of two_bolt; did you mean tip?'),
    ],
)
def test_what_does_not_go_together_is_told_before_any_job(study, changes, case, line):
    with pytest.raises(ConfigError) as refused:
        study(case, **changes)
    assert line in str(refused.value), str(refused.value)
