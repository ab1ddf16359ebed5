"""Names of joints, bases and coordinates: what they stand for, and what is refused."""

import pickle
import re

import pytest

from boltjoint.names import Basis, ComparedBasis, Coordinates, JointName, Preload, repeats_pattern


@pytest.mark.parametrize(
    ("grammar", "name"),
    [
        (JointName, "regions"),
        (JointName, "regions=0"),
        (JointName, "node-to-node/table"),
        (JointName, "regions=4/elements=auto"),
        (JointName, "clusters=4/table=2"),
        (JointName, None),
        (Basis, "free"),
        (Basis, "enriched-301"),
        (ComparedBasis, "free-1"),
        (Coordinates, "rdnm"),
        (Coordinates, "complex-linear"),
        (Coordinates, 1),
    ],
)
def test_another_name_is_refused_with_what_is_allowed(grammar, name):
    with pytest.raises(ValueError, match=re.escape(f"{grammar.QUANTITY} {name!r} must be")):
        grammar(name)


@pytest.mark.parametrize(
    "name", [JointName("regions=6/elements=7"), Basis("free-4"), Coordinates("complex-rdnm-2")]
)
def test_a_name_is_its_string_in_another_process_too(name):
    copy = pickle.loads(pickle.dumps(name))
    assert (copy, vars(copy), type(copy)) == (str(name), vars(name), type(name))


@pytest.mark.parametrize("grammar", [JointName, Basis, Coordinates])
def test_a_wildcard_has_no_groups_and_fits_names(grammar):
    example = {"JointName": "clusters=auto/table", "Basis": "free-8", "Coordinates": "rdnm-1"}
    pattern = re.compile(f"x/({grammar.wildcard()})/y")
    assert pattern.groups == 1
    assert pattern.fullmatch(f"x/{example[grammar.__name__]}/y")


@pytest.mark.parametrize(
    ("name", "parts", "words"),
    [
        ("node-to-node", (None, None, None, None), "node-to-node"),
        ("regions=1", ("regions", 1, None, None), "1 region"),
        ("regions=auto", ("regions", "auto", None, None), "regions to tolerance"),
        ("clusters=12", ("clusters", 12, None, None), "12 clusters"),
        ("clusters=auto", ("clusters", "auto", None, None), "clusters to tolerance"),
        ("regions=6/elements=7", ("regions", 6, "elements", 7), "6 regions of 7 elements"),
        ("clusters=1/elements=1", ("clusters", 1, "elements", 1), "1 cluster of 1 element"),
        (
            "clusters=12/harmonic=7",
            ("clusters", 12, "harmonic", 7),
            "12 clusters of 7 elements, harmonic fit",
        ),
        (
            "regions=auto/harmonic=1",
            ("regions", "auto", "harmonic", 1),
            "regions to tolerance of 1 element, harmonic fit",
        ),
        ("regions=6/table", ("regions", 6, "table", None), "6 regions, tabulated"),
    ],
)
def test_a_joint_is_parsed_and_labelled(name, parts, words):
    joint = JointName(name)
    assert joint == name
    assert (joint.division, joint.count, joint.reduction, joint.elements) == parts
    assert joint.label == words
    if joint.division is not None:
        # which is the folder above that of what stands for the elements
        assert joint.regions == name.split("/")[0]


@pytest.mark.parametrize(
    "name",
    [
        "",
        "regions=0",
        "regions=6/",
        "regions=6/elements=0",
        "regions=06",
        "regions=6\n",
        "clusters",
        "clusters=",
        "clusters=automatic",
        "bands=6",
        "node-to-node/table",
        "regions=6/table=1",
        "regions=6/harmonic",
        "regions=6/elements=auto",
        "regions=6/elements=4/table",
        "regions=6/loops=4",
    ],
)
def test_other_names_of_joints_are_refused(name):
    with pytest.raises(ValueError, match=re.escape(repr(name))) as refused:
        JointName(name)
    for part in ("node-to-node", "regions=N", "clusters=N", "auto", "/elements=M", "/table"):
        assert part in str(refused.value)


def test_a_basis_is_parsed():
    bases = [Basis(name) for name in ("free-16", "enriched-40")]
    assert [basis.vectors for basis in bases] == [16, 40]
    assert [basis.is_contact_adapted for basis in bases] == [False, True]
    automatic = Basis("enriched-auto")
    assert (automatic.vectors, automatic.is_contact_adapted) == ("auto", True)
    assert (automatic.fewest, automatic.most) == (8, 300)
    for name in ("free", "free-auto", "free-0", "enriched-", "enriched-04", "enrich-4", "free-4\n"):
        with pytest.raises(ValueError, match="must be free-N, all-N, enriched-N or enriched-auto"):
            Basis(name)


@pytest.mark.parametrize(
    ("name", "parts", "words", "short"),
    [
        ("linear", ("linear", None), "linear modes", "linear modes"),
        ("backbone", ("backbone", None), "backbone", "backbone"),
        ("rdnm-1", ("real", 1), "1 response-dependent mode", "1 RDNM"),
        ("rdnm-2", ("real", 2), "2 response-dependent modes", "2 RDNM"),
        (
            "complex-rdnm-3",
            ("complex", 3),
            "3 complex response-dependent modes",
            "3 complex RDNM",
        ),
    ],
)
def test_coordinates_are_parsed_and_labelled(name, parts, words, short):
    coordinates = Coordinates(name)
    assert (coordinates.kind, coordinates.count) == parts
    assert (coordinates.label, coordinates.short_label) == (words, short)


@pytest.mark.parametrize(
    "name", ["", "linear-1", "backbone-1", "rdnm", "rdnm-0", "complex", "complex-rdnm", "rdnm-1\n"]
)
def test_other_names_of_coordinates_are_refused(name):
    with pytest.raises(ValueError, match="must be linear, backbone, rdnm-N or complex-rdnm-N"):
        Coordinates(name)


@pytest.mark.parametrize("ratios", [(0.5, 1, 1), (1, *59 * [0.8]), (*30 * [1], 0, *29 * [1])])
def test_a_preload_of_many_bolts_is_a_short_name_of_its_tensions(ratios):
    preload = Preload.of(10000.0, ratios)
    assert Preload(str(preload)).of_bolts == tuple(10000 * ratio for ratio in ratios)
    assert re.fullmatch(Preload.wildcard(), preload)
    assert len(preload) < 40
    assert not repeats_pattern(preload)
