"""Names of joints, bases and coordinates: what they stand for, and what is refused."""

import doctest
import pickle
import re

import pytest

from boltjoint import names
from boltjoint.names import Basis, ComparedBasis, Coordinates, JointName


def test_examples_hold():
    assert doctest.testmod(names).failed == 0


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
        (Basis, "enriched-101"),
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
