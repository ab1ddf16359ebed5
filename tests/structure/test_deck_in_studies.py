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


def test_bolts_have_preloads_by_their_names_or_by_the_deck(study, text):
    def preload(case, **changes):
        return study(case, **changes).case("small").preload

    none = {"preload_N": None}
    assert preload(none) == "10000"
    assert preload(none, preload_N=8000) == "8000"
    assert preload({"preload_N": 5000}) == "5000"
    assert preload({"bolt_preloads_N": {"cut-1": 3000}}) == "10000,3000"
    assert preload({"bolt_preloads_N": {"cut-0": 30_000}}) == "30000,10000"
    last = text.rindex("10000.0")
    other = f"{text[:last]}4000.0{text[last + 7 :]}"
    assert preload(none, text=other) == "10000,4000"
    assert preload(none | {"preload_ratios": [0.5, 1]}, text=other) == "5000,4000"
    assert preload(none | {"bolt_preloads_N": {"cut-0": 2000}}, text=other) == "2000,4000"
    # without a load of one bolt all are named, or have a preload
    some = f"{text[:last]}0.0{text[last + 7 :]}"
    by_name = none | {"bolt_preloads_N": {"cut-0": 2000}}
    with pytest.raises(ConfigError, match=r"preload_N: .*gives its bolts none, nor does .* cut-1"):
        preload(by_name, text=some)
    by_name["bolt_preloads_N"]["cut-1"] = 1000
    assert preload(by_name, text=some) == "2000,1000"
    with pytest.raises(ConfigError, match=r"preload_N: .*is missing: .* gives its bolts none$"):
        preload(none, text=some)


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
            {},
            {"preload_N": None, "preload_ratios": [1]},
            "must have 2 ratios, one for each bolt of two_bolt",
        ),
        (
            {},
            {"bolt_preloads_N": {"cut_1": 1, "cut-3": 1}},
            "bolt_preloads_N.cut_1: 1 is no bolt of two_bolt; did you mean cut-1?",
        ),
        (
            {},
            {"bolt_preloads_N": {"cut-1": 1}, "preload_ratios": [1, 1]},
            "must not stand beside preload_ratios",
        ),
        ({}, {"bolt_preloads_N": {"cut-0": 0, "cut-1": 0}}, "must have one above 0: a bolt that"),
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
