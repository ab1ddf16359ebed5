"""YAML as data: what is read, and what is refused at which line and column."""

import pytest

from boltjoint.config.strict_yaml import (
    LARGEST_FILE,
    TextError,
    as_text,
    parse_mapping,
    read_mapping,
    resolve_types,
)

LIMITS = "must be 0 or a number of a magnitude from 1e-30 to 1e+30"
#: 2^20 words once its aliases are expanded
BOMB = "k0: &k0 word\n" + "".join(f"k{i + 1}: &k{i + 1} [*k{i}, *k{i}]\n" for i in range(20))


@pytest.mark.parametrize(
    ("word", "value"),
    [
        # numbers and booleans of YAML 1.2, where 1.1 has others
        ("010", 10),
        ("-7", -7),
        ("+1", 1),
        ("0x10", 16),
        ("0o10", 8),
        ("1e8", 1e8),
        ("1E-3", 1e-3),
        (".5", 0.5),
        ("5.", 5.0),
        ("true", True),
        ("FALSE", False),
        ("null", None),
        ("~", None),
        ("", None),
        # words
        ("1:30", "1:30"),
        ("1_000", "1_000"),
        ("0b1", "0b1"),
        ("yes", "yes"),
        ("Off", "Off"),
        ("2001-01-01", "2001-01-01"),
        ("=", "="),
        ("'1e8'", "1e8"),
        ('"true"', "true"),
        ("[1, two, [3.0]]", [1, "two", [3.0]]),
        ("{b: {c: no}}", {"b": {"c": "no"}}),
    ],
)
def test_values_are_of_the_core_schema_of_yaml_1_2(word, value):
    content = parse_mapping(f"a: {word}\n")
    assert content == {"a": value}
    assert type(content["a"]) is type(value)


def test_a_merge_key_merges_nothing():
    assert parse_mapping("<<: {a: 1}\nb: 2\n") == {"<<": {"a": 1}, "b": 2}


def test_a_directive_for_yaml_1_1_changes_nothing():
    assert parse_mapping("%YAML 1.1\n---\na: yes\n") == {"a": "yes"}


HOSTILE = {
    "beyond Unicode": ('a: "\\U00110000"\n', "1:1: is not YAML that can be read"),
    "far beyond Unicode": ('a: "\\UFFFFFFFF"\n', "1:1: is not YAML that can be read"),
    "long version": (f"%YAML 1.{'9' * 5000}\n---\na: 1\n", "1:1: is not YAML that can be read"),
    "key twice": ("a: 1\nb: 2\na: 3\n", '3:1: the key "a" stands twice, first in line 1'),
    "inner key twice": ("a:\n  b: 2\n  b: 3\n", '3:3: the key "b" stands twice, first in line 2'),
    "key in quotes twice": ("a: 1\n'a': 2\n", '2:1: the key "a" stands twice, first in line 1'),
    "number as key": ("1: a\n", "1:1: the key 1 must be text"),
    "true as key": ("true: a\n", "1:1: the key true must be text"),
    "list as key": ("[a, b]: c\n", '1:1: the key ["a", "b"] must be text'),
    "mapping as key": ("? {a: b}\n: c\n", '1:3: the key {"a": "b"} must be text'),
    "no key": ("?\n: a\n", "1:2: the key null must be text"),
    "open list": ("a: [1, 2\nb: 3\n", "2:2: expected ',' or ']', but got ':'"),
    "open quote": ('a: "b\n', "2:1: found unexpected end of stream"),
    "tab": ("a:\n\tb: 1\n", "2:1: found character '\\t' that cannot start any token"),
    "two colons": ("a: b: c\n", "1:5: mapping values are not allowed here"),
    "escape": ('a: "\\q"\n', "1:6: found unknown escape character 'q'"),
    "list": ("- a\n", "1:1: must hold keys with values, as in `description: ...`"),
    "word": ("a\n", "1:1: must hold keys with values, as in `description: ...`"),
    "nothing": ("", "1:1: must hold keys with values, as in `description: ...`"),
    "comment": ("# a: 1\n", "1:1: must hold keys with values, as in `description: ...`"),
    "anchor": ("a: &b 1\n", "1:4: anchors (&) and aliases (*) are not allowed"),
    "alias": ("a: *b\n", "1:4: anchors (&) and aliases (*) are not allowed"),
    "alias bomb": (BOMB, "1:5: anchors (&) and aliases (*) are not allowed"),
    "list in itself": ("a: &a [*a]\n", "1:4: anchors (&) and aliases (*) are not allowed"),
    "tag": ("a: !!str 1\n", '1:4: the tag "tag:yaml.org,2002:str" is not allowed'),
    "own tag": ("a: !b 1\n", '1:4: the tag "!b" is not allowed'),
    "object": (
        "a: !!python/object/apply:os.system ['touch ran']\n",
        '1:4: the tag "tag:yaml.org,2002:python/object/apply:os.system" is not allowed',
    ),
    "two documents": ("a: 1\n---\nb: 2\n", "2:1: begins a second document; a file holds one"),
    "empty document": ("---\n---\na: 1\n", "2:1: begins a second document; a file holds one"),
    "yaml 2": ("%YAML 2.0\n---\na: 1\n", "1:1: found incompatible YAML document"),
    "5000 digits": (f"a: {5000 * '9'}\n", f'1:4: a: "{56 * "9"}... {LIMITS}'),
    "5000 zeros": (f"a: {5000 * '0'}1\n", f'1:4: a: "{56 * "0"}... {LIMITS}'),
    "400 digits": (f"a: {400 * '9'}\n", f'1:4: a: "{56 * "9"}... {LIMITS}'),
    "5000 hexadecimal digits": (f"a: 0x{5000 * 'f'}\n", '1:4: a: "0xfff'),
    "large exponent": ("a: [1, -1e400]\n", f'1:8: a[1]: "-1e400" {LIMITS}'),
    "beyond what is computed with": ("a: 1.1e30\n", f'1:4: a: "1.1e30" {LIMITS}'),
    "next to zero": ("a: -9.9e-31\n", f'1:4: a: "-9.9e-31" {LIMITS}'),
    "rounded to zero": ("a: 1e-400\n", f'1:4: a: "1e-400" {LIMITS}'),
    "infinity": ("a: -.inf\n", '1:4: a: "-.inf" must be a finite number'),
    "no number": ("a: .NaN\n", '1:4: a: ".NaN" must be a finite number'),
    "2000 lists": (f"a: {2000 * '['}", "1:23: is nested deeper than 20 levels"),
    "2000 mappings": (f"a: {2000 * '{a: '}", "1:80: is nested deeper than 20 levels"),
    "2000 dashes": (f"a:\n {2000 * '- '}1\n", "2:40: is nested deeper than 20 levels"),
    "nul": ("a: b\0c\n", '1:5: "\\u0000" is no character of a text'),
    "nul in quotes": ('a: "b\\0c"\n', '1:4: "\\u0000" is no character of a text'),
    "escape sequence": ("a: 1\nb: \x1b[31m\n", '2:4: "\\u001b" is no character of a text'),
    "half a pair": ('a: "\\ud800"\n', '1:4: "\\ud800" is no character of a text'),
    "line of Unicode": ("a: b\u2028c: d\n", '1:5: "\\u2028" is no character of a text'),
}


@pytest.mark.parametrize("kind", HOSTILE)
def test_what_is_no_data_is_refused_in_one_line(kind):
    text, line = HOSTILE[kind]
    with pytest.raises(TextError) as refused:
        parse_mapping(text)
    assert str(refused.value).startswith(line)
    assert len(str(refused.value).splitlines()) == 1
    assert len(str(refused.value)) < 200


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"a: 1\nb\xc3\xbc: \xff\n", "2:5: is not text in UTF-8"),
        ("a: 1\n".encode("utf-16"), "1:1: is not text in UTF-8"),
        (b"# a\n" * LARGEST_FILE, f"is larger than {LARGEST_FILE} bytes"),
    ],
)
def test_files_that_are_no_text_are_refused(tmp_path, content, line):
    path = tmp_path / "a.yaml"
    path.write_bytes(content)
    with pytest.raises(TextError) as refused:
        read_mapping(path)
    assert str(refused.value) == line


def test_a_file_may_begin_with_a_byte_order_mark_and_end_lines_as_elsewhere(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: 1\r\nb: 2\r\n")
    assert read_mapping(path) == {"a": 1, "b": 2}


def test_a_file_of_the_largest_size_is_read(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text(f"a: [{'1, ' * (LARGEST_FILE // 3 - 10)}1]\n", encoding="utf-8")
    assert len(read_mapping(path)["a"]) == LARGEST_FILE // 3 - 9


def test_words_of_the_command_line_are_typed_as_in_a_file():
    words = {"a": "1e-6", "b": ["2", "two", {"c": "false"}], "d": 3, "e": True, "f": "-0"}
    typed = {"a": 1e-6, "b": [2, "two", {"c": False}], "d": 3, "e": True, "f": 0}
    assert resolve_types(words) == (typed, [])


def test_numbers_of_the_command_line_have_the_limits_of_a_file():
    # some are numbers already, as Snakemake reads them
    words = {"a": ["1e999", ".inf"], "b": {"c": 1e31}, "d": -(10**400), "e": float("nan")}
    _, problems = resolve_types(words)
    assert [path for path, _ in problems] == [("a", 0), ("a", 1), ("b", "c"), ("d",), ("e",)]
    sentences = [sentence for _, sentence in problems]
    assert sentences[:3] == [
        f'"1e999" {LIMITS}',
        '".inf" must be a finite number',
        f"1e+31 {LIMITS}",
    ]
    assert all(sentence.endswith(LIMITS) for sentence in sentences[3:])


@pytest.mark.parametrize("text", ["1e30", "-1e30", "1e-30", "0", "-0.0", "0e999", f"1{30 * '0'}"])
def test_numbers_within_the_limits_are_read(text):
    assert float(parse_mapping(f"a: {text}\n")["a"]) == float(text)


def test_a_decimal_comma_in_braces_is_told():
    for text, example in (("0,15", "0.15"), ("12,05", "12.05"), ("-1,5", "-1.5")):
        with pytest.raises(TextError, match=f"a number with decimals has a point, as in {example}"):
            parse_mapping(f"a: {{b: 1, c: {text}}}\n")
    with pytest.raises(TextError, match=r"the key 15 must be text$"):
        parse_mapping("a: {b: word, 15}\n")


def test_values_are_shown_in_one_short_line():
    assert as_text({"a": [1, None]}) == '{"a": [1, null]}'
    assert as_text("bölt") == '"bölt"'
    assert as_text(100 * "a") == f'"{56 * "a"}...'
    for text in ("a\nb", "a\u2028b", "\x1b[31m", "\ud800"):
        assert as_text(text).isprintable()
