"""CSV files as spreadsheets write them, and what is said of others."""

import random
import re

import numpy as np
import pytest

from boltjoint.config.csv_table import CsvTable, TableError, read_file
from boltjoint.config.strict_yaml import DECIMAL, LIMITS, TextError, parse_mapping
from boltjoint.regular_file import UnsuitableFile

PLAIN = "a,b\n1,0.25\n-2e3,.5\n"


def columns_of(content, tmp_path):
    file = tmp_path / "table.csv"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return CsvTable(read_file(file), "table.csv").columns()


@pytest.mark.parametrize(
    "content",
    [
        PLAIN,
        PLAIN.rstrip("\n"),
        PLAIN.encode("utf-8-sig"),
        PLAIN.replace("\n", "\r\n"),
        PLAIN.replace("\n", "\r"),
        f"{PLAIN}\n \n",
        f"{PLAIN},\n,\n",
        PLAIN.replace(",", " ,\t "),
        '"a","b"\n"1","0.25"\n"-2e3",".5"\n',
        "a;b\n1;0,25\n-2e3;,5\n",
        "a;b\r\n1;0,25\r\n-2e3;,5\r\n;\r\n".encode("utf-8-sig"),
        '"a";"b"\n"1";"0,25"\n"-2e3";",5"\n',
    ],
)
def test_tables_of_spreadsheets_are_read(content, tmp_path):
    found = columns_of(content, tmp_path)
    assert list(found) == ["a", "b"]
    np.testing.assert_array_equal(found["a"], [1, -2000])
    np.testing.assert_array_equal(found["b"], [0.25, 0.5])


def test_numbers_as_programs_write_them_are_those_of_single_lines(tmp_path):
    chance = random.Random(5)
    forms = "{:.17g}", "{:+.3e}", "{:.1f}", "{:.0f}", "{:.0f}.", "{:.2E}"
    values = [chance.gauss(0, 1) * 10 ** chance.uniform(-3, 6) for _ in range(40_000)]
    cells = [chance.choice(forms).format(value) for value in values]
    lines = [",".join(cells[start : start + 2]) for start in range(0, len(cells), 2)]
    plain = columns_of("a,b\n" + "\n".join(lines), tmp_path)
    # a cell with a space is read as those of spreadsheets are, and all others with it
    single = columns_of("a,b\n" + "\n".join([*lines[:-1], f"{lines[-1]} "]), tmp_path)
    for name, place in (("a", 0), ("b", 1)):
        expected = [float(cell) for cell in cells[place::2]]
        np.testing.assert_array_equal(plain[name], expected)
        np.testing.assert_array_equal(single[name], expected)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("a,b\n1,2\n\n3,4\n", "3: must not be blank: other lines follow"),
        ("a,b\n1,2\n,\n3,4\n", "3: must not be blank: other lines follow"),
        ("a,b\n1,2\n3,\n", '3: b: "" must be a number'),
        ("a,b\n1,0,25\n", "2: must have 2 values, as many as keys"),
        ("a,b\n1,0,25,0\n", "2: must have 2 values, as many as keys: are these decimal commas?"),
        (
            "a\n0,25\n",
            "2: must have 1 values, as many as keys: are these decimal commas? They need",
        ),
        ("a\tb\n1\t2\n", "1: must have commas or semicolons between cells, not tabs"),
        ("sep=;\na;b\n1;2\n", "1: must have the names of the columns: delete the line sep="),
        ('a,b\n1,"0,25"\n', '2: b: "0,25" must be a number'),
        # thousands, in the languages of either
        ('a,b\n1,"10,000"\n', '2: b: "10,000" must be a number'),
        (
            "a;b\n1;10.000\n",
            '2: b: "10.000" must be a number without decimal point: semicolons between cells go '
            "with decimal commas",
        ),
        ("a;b\n1;10.000,5\n", '2: b: "10.000,5" must be a number without decimal point: '),
        ('a,b\n1,"2\n3,4\n', "3: cannot be read as CSV: unexpected end of data"),
        ('a,b\n1,"2"3\n', "2: cannot be read as CSV: ',' expected after '\"'"),
        (f"a,b\n1,{131_000 * '7'}\n", f'2: b: "{56 * "7"}... must be {LIMITS}'),
        ("a,b\n1,2\n3,1e31\n", f'3: b: "1e31" must be {LIMITS}'),
        ("a;b\n1;-9,9e-31\n", f'2: b: "-9,9e-31" must be {LIMITS}'),
        (f"a,b\n1,{200_000 * '7'}\n", "2: cannot be read as CSV: field larger than field limit"),
        ('a,b\n1,"' + 100 * "7\n" + '"\n', '102: b: "7\\n7\\n'),
        ("a,b\n1,\0\n", '2: b: "\\u0000" must be a number'),
    ],
)
def test_what_is_wrong_is_said_in_a_line(content, problem, tmp_path):
    with pytest.raises(TableError) as caught:
        columns_of(content, tmp_path)
    assert str(caught.value).startswith(f"table.csv:{problem}")
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 200


@pytest.mark.parametrize(
    "cell", ["1_0", "٣", "0x10", "inf", "nan", "1 0", "1e", ".", "+", "−1", "1\u00a0"]
)
def test_other_numbers_are_none(cell, tmp_path):
    with pytest.raises(TableError, match=r"table\.csv:3: b: .* must be a number$"):
        columns_of(f"a,b\n1,2\n3,{cell}\n5,6\n", tmp_path)


def test_numbers_are_those_of_other_files(tmp_path):
    """Random cells: what is read is what YAML takes as a decimal number, with the same value."""
    draw = random.Random(1)
    count = 0
    for _ in range(5000):
        cell = "".join(draw.choices("0123456789.eE+-_ x", k=draw.randint(1, 6))).strip()
        if not cell:
            continue
        try:
            (value,) = columns_of(f"a\n{cell}\n", tmp_path)["a"]
        except TableError:
            if DECIMAL.fullmatch(cell):
                with pytest.raises(TextError, match=re.escape(LIMITS)):
                    parse_mapping(f"a: {cell}")
        else:
            assert DECIMAL.fullmatch(cell)
            assert value == float(cell)
            count += 1
    assert count > 500


@pytest.mark.parametrize("content", [b"a,b\n1,\xff\n", PLAIN.encode("utf-16")])
def test_another_encoding_is_refused_with_what_to_do(content, tmp_path):
    said = "table.csv: is not text in UTF-8: save it as CSV in UTF-8"
    with pytest.raises(UnsuitableFile, match=re.escape(said)):
        columns_of(content, tmp_path)
