"""What checks of arguments return, and how they say what is wrong."""

import numpy as np
import pytest
import xarray as xr

from boltjoint import checks


@pytest.mark.parametrize(
    "value",
    [[[1, 2], [3, 4]], np.array([[1, 3], [2, 4]]).T, np.array([[1, 2], [3, 4]], np.float32)],
)
def test_numbers_become_a_contiguous_array_of_floats(value):
    found = checks.array("a", value, (2, "columns"))
    assert found.dtype == np.float64
    assert found.flags.c_contiguous
    np.testing.assert_array_equal(found, [[1, 2], [3, 4]])


def test_an_array_of_the_right_kind_is_not_copied():
    value, at = np.ones((2, 3)), np.arange(3)
    assert checks.array("a", value, (2, 3), above=0) is value
    assert checks.indices("at", at, count=3) is at


def test_a_scalar_stays_a_scalar():
    assert checks.array("a", 2).shape == ()


@pytest.mark.parametrize(
    ("value", "shape", "limits", "message"),
    [
        ([1.0, 2.0], (3,), {}, "a has shape (2,), expected (3,)"),
        ([[1.0, 2.0]], ("points", 3), {}, "a has shape (1, 2), expected (points, 3)"),
        ([[1.0], [1.0, 2.0]], None, {}, "a must be an array of real numbers: its rows differ"),
        ("nope", None, {}, "a must be an array of real numbers, not of type <U4"),
        ([None, 1.0], None, {}, "a must be an array of real numbers, not of type object"),
        ([1j], None, {}, "a must be an array of real numbers, not of type complex128"),
        ([True], None, {}, "a must be an array of real numbers, not of type bool"),
        ([1.0, np.nan], None, {}, "a must be finite, but is nan at index 1"),
        ([[0.0, np.inf]], None, {}, "a must be finite, but is inf at index (0, 1)"),
        (-np.inf, None, {}, "a must be finite, but is -inf"),
        ([2.0, 0.0], None, {"above": 0}, "a must be positive, but is 0 at index 1"),
        ([-1.0], None, {"at_least": 0}, "a must be at least 0, but is -1 at index 0"),
        ([3.0], None, {"above": 1, "below": 3}, "a must be above 1 and below 3, but is 3"),
        ([3.0], None, {"at_most": 2}, "a must be at most 2, but is 3 at index 0"),
    ],
)
def test_other_arrays_are_refused(value, shape, limits, message):
    with pytest.raises(ValueError) as refused:
        checks.array("a", value, shape, **limits)
    assert str(refused.value).startswith(message)


def test_what_iterations_reach_need_not_be_finite():
    found = checks.array("a", [np.nan, np.inf], finite=False)
    np.testing.assert_array_equal(found, [np.nan, np.inf])


def test_indices_are_whole_and_in_range():
    found = checks.indices("at", np.array([[0], [2]], np.int8), ("rows", 1), count=3)
    assert found.dtype == np.int64
    assert checks.indices("at", []).dtype == np.int64
    for value in ([0.0, 1.0], [0.5], [True], ["0"]):
        with pytest.raises(ValueError, match="at must be an array of whole numbers, not of type"):
            checks.indices("at", value)
    with pytest.raises(ValueError, match="at must be at least 0 and below 3, but is 3 at index 1"):
        checks.indices("at", [0, 3], count=3)
    with pytest.raises(ValueError, match="at must be at least 0, but is -1 at index 0"):
        checks.indices("at", [-1, 3])


def test_flags_are_booleans():
    assert checks.flags("on", [True, False], (2,)).tolist() == [True, False]
    with pytest.raises(ValueError, match="on must be an array of booleans, not of type int64"):
        checks.flags("on", [1, 0])


@pytest.mark.parametrize("value", [2, 2.0, np.float32(2), np.int8(2), np.array(2.0)])
def test_a_number_becomes_a_float(value):
    found = checks.number("x", value, above=0)
    assert type(found) is float
    assert found == 2


@pytest.mark.parametrize("value", ["2", None, True, np.nan, np.inf, 1j, [2.0], np.bool_(1)])
def test_what_is_no_number_is_refused(value):
    with pytest.raises(ValueError, match=r"x is .*: it must be a finite number"):
        checks.number("x", value)


def test_a_number_out_of_its_limits_is_refused():
    with pytest.raises(ValueError, match=r"x is 0\.0: it must be positive"):
        checks.number("x", 0.0, above=0)
    with pytest.raises(ValueError, match=r"x is 2: it must be at least 0 and at most 1"):
        checks.number("x", 2, at_least=0, at_most=1)


def test_whole_numbers():
    found = checks.whole("n", np.int16(3), at_least=1)
    assert type(found) is int
    for value in (3.0, "3", True, None, 2.5):
        with pytest.raises(ValueError, match=r"n is .*: it must be a whole number"):
            checks.whole("n", value)
    with pytest.raises(ValueError, match="n is 0: it must be at least 1"):
        checks.whole("n", 0, at_least=1)


def test_true_and_false():
    assert checks.flag("on", np.bool_(0)) is False
    with pytest.raises(ValueError, match="on is 'x': it must be True or False"):
        checks.flag("on", "x")


def test_one_of_several_words():
    assert checks.choice("how", "a", ("a", "b")) == "a"
    for value in ("c", "", None, 1, ["a"]):
        with pytest.raises(ValueError, match=r"how .* is not known; allowed: a, b"):
            checks.choice("how", value, ("a", "b"))


def test_one_or_more_numbers():
    assert checks.numbers("f", np.array([1, 2])) == [1.0, 2.0]
    with pytest.raises(ValueError, match="f is empty"):
        checks.numbers("f", [])
    with pytest.raises(ValueError, match="f must be positive"):
        checks.numbers("f", [1.0, 0.0])


def test_two_numbers_that_increase():
    assert checks.interval("window", [1, 2]) == (1.0, 2.0)
    with pytest.raises(ValueError, match="window is from 2 to 2: it must increase"):
        checks.interval("window", (2.0, 2.0))
    for value in ((0.0, 1.0), (1.0, np.nan), (1.0,), 1.0, "ab"):
        with pytest.raises(ValueError, match="window"):
            checks.interval("window", value)


def test_values_that_ascend():
    np.testing.assert_array_equal(checks.ascending("x", [-1, 0, 3]), [-1, 0, 3])
    for value in ([0.0], [0.0, 0.0], [1.0, 0.0], [0.0, np.nan]):
        with pytest.raises(ValueError, match="x"):
            checks.ascending("x", value)


def test_objects_of_a_class():
    checks.instance("n", 1, int, float)
    with pytest.raises(ValueError, match="n is of type str: it must be int or float"):
        checks.instance("n", "1", int, float)


def test_variables_of_a_dataset():
    data = xr.Dataset({"a": (("x", "y"), [[1, 2, 3], [4, 5, 6]]), "at": ("x", [0, 1])})
    np.testing.assert_array_equal(
        checks.variable("data", data, "a", ("y", "x"), above=0), [[1, 4], [2, 5], [3, 6]]
    )
    np.testing.assert_array_equal(
        checks.index_variable("data", data, "at", ("x",), count=2), [0, 1]
    )
    with pytest.raises(ValueError, match="data has no variable 'b'"):
        checks.variable("data", data, "b", ("x",))
    with pytest.raises(ValueError, match="a of data is over x, y, expected x"):
        checks.variable("data", data, "a", ("x",))
    with pytest.raises(ValueError, match="a of data must be above 1, but is 1 at index"):
        checks.variable("data", data, "a", ("x", "y"), above=1)
    with pytest.raises(ValueError, match="at of data must be at least 0 and below 1"):
        checks.index_variable("data", data, "at", ("x",), count=1)
    with pytest.raises(ValueError, match="data is of type dict: it must be Dataset"):
        checks.variable("data", {"a": 1}, "a", ())


def test_numbers_that_overflow_and_ragged_lists_name_the_argument():
    with pytest.raises(ValueError, match="force is"):
        checks.number("force", 10**400)
    with pytest.raises(ValueError, match="places"):
        checks.indices("places", [[1], [1, 2]])
