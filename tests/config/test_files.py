"""Hundreds of wrong files: each is refused in one line that says where, before any job."""

import json
import shutil

import pytest
from mutations import samples
from small_study import ASSEMBLY, CASE, SETTINGS, snakemake, write
from snakemake.common.configfile import load_configfile
from snakemake.io import PeriodicityDetector
from test_strict_yaml import HOSTILE

from boltjoint.config.reference import SCHEMAS
from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError
from boltjoint.reproduction.case_studies import CASE_STUDIES, INDEX, name_case_studies
from boltjoint.structure.makers.registry import make

CONFIG, CASE_FILE, ASSEMBLY_FILE, STUDY = FILES = (
    "config/config.yaml",
    "config/cases/small.yaml",
    "config/assemblies/two_bolt.yaml",
    "mine.yaml",
)
WASHER = {"thickness_mm": 1.6, "diameter_mm": 16, "hole_diameter_mm": 8.4}
# copies: the same object twice is an alias in YAML
OWN = {
    "material": dict(ASSEMBLY["material"]),
    "washer": WASHER | {"material": dict(ASSEMBLY["material"])},
}
BOLTED = ASSEMBLY | {"bolts": ASSEMBLY["bolts"] | OWN}
CONTENTS = dict(zip(FILES, (SETTINGS, CASE, BOLTED, {"cases": ["small"]}), strict=True))
MODELS = {CONFIG: SCHEMAS["config"], CASE_FILE: SCHEMAS["case"], ASSEMBLY_FILE: SCHEMAS["assembly"]}

#: what no file may hold as a line of its own, and line after it, column and words of the problem
BAD_LINES = {
    "new: @word": (0, 6, "found character '@' that cannot start any token"),
    "new: word: word": (0, 10, "mapping values are not allowed here"),
    "new: 'a' b": (0, 10, "expected <block end>, but found '<scalar>'"),
    "new: *word": (0, 6, "anchors (&) and aliases (*) are not allowed"),
    "new: !!set {a}": (0, 6, 'the tag "tag:yaml.org,2002:set" is not allowed'),
    "new: 1e999": (0, 6, '"1e999" must be 0 or a number of a magnitude from 1e-30 to 1e+30'),
    "new: {a: 0,15}": (
        0,
        12,
        "the key 15 must be text: a number with decimals has a point, as in 0.15",
    ),
    "new: [1, 2": (1, None, "expected ',' or ']', but got"),
    "[new]: 1": (0, 1, 'the key ["new"] must be text'),
    "2: 1": (0, 1, "the key 2 must be text"),
    "new: {a: 1, a: 2}": (0, 13, 'the key "a" stands twice, first in line'),
    "\tnew: 1": (0, 1, "found character '\\t' that cannot start any token"),
    "new: \x07": (0, 6, '"\\u0007" is no character of a text'),
}


@pytest.fixture
def study(tmp_path):
    for file, content in CONTENTS.items():
        write(tmp_path / file, content)
    load_study(tmp_path, {"study": STUDY})
    return tmp_path


def lines_of(study, changes=None):
    """The problems of a study, as lines."""
    with pytest.raises(ConfigError) as refused:
        load_study(study, changes)
    lines = str(refused.value).splitlines()
    assert all(line.isprintable() and len(line) < 500 for line in lines)
    return lines


def problem_of(study, changes=None):
    """The only problem of a study, as a line."""
    (line,) = lines_of(study, changes)
    return line


def dotted(path):
    keys = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return keys.removeprefix(".")


def test_a_wrong_value_is_said_with_file_and_key(study):
    """Misspelt, missing and additional keys, values of other kinds, beyond limits, and repeated."""
    wrong = 0
    for file, model in MODELS.items():
        for path, content, verdict in samples(CONTENTS[file], model, number=1):
            # keys that contradict each other may be said of either
            if verdict != "refused":
                continue
            (study / file).write_text(json.dumps(content), encoding="utf-8")
            place, key, words = lines_of(study)[0].split(": ", maxsplit=2)
            assert place == file
            assert key.startswith(dotted(path[:-1])), (path, key)
            assert words
            wrong += 1
        write(study / file, CONTENTS[file])
    assert wrong > 250


def test_a_line_that_is_no_yaml_is_said_with_line_and_column(study):
    refused = 0
    for file in FILES:
        text = (study / file).read_text(encoding="utf-8")
        lines = text.splitlines()
        outermost = [index for index, line in enumerate(lines) if line[0].isalpha()]
        for index in outermost:
            for bad, (after, column, words) in BAD_LINES.items():
                changed = [*lines[:index], bad, *lines[index:]]
                (study / file).write_text("\n".join(changed), encoding="utf-8")
                line = problem_of(study, {"study": STUDY})
                where = f"{file}:{index + 1 + after}:"
                assert line.startswith(where if column is None else f"{where}{column}: "), line
                assert words in line
                refused += 1
        (study / file).write_text(text, encoding="utf-8")
    assert refused > 200


@pytest.mark.parametrize("file", FILES)
def test_what_is_no_data_is_refused_in_every_file(study, file):
    for text, line in HOSTILE.values():
        (study / file).write_text(text, encoding="utf-8")
        assert problem_of(study, {"study": STUDY}).startswith(f"{file}:{line}")


@pytest.mark.parametrize("file", FILES)
@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"a: \xff\n", ":1:4: is not text in UTF-8"),
        (b"\xff\xfea\0:\0", ":1:1: is not text in UTF-8"),
        (b"#" * 10**6, ": is larger than 200000 bytes"),
        (None, ": cannot be read: Is a directory"),
    ],
)
def test_a_file_that_is_no_text_is_refused(study, file, content, words):
    (study / file).unlink()
    if content is None:
        (study / file).mkdir()
    else:
        (study / file).write_bytes(content)
    assert problem_of(study, {"study": STUDY}) == file + words


@pytest.mark.parametrize("file", [CONFIG, STUDY])
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("large", '"large" is not in config/cases; there are: small'),
        ("smal", '"smal" is not in config/cases; did you mean small?'),
        (8 * "abcdefgh", f'"{7 * "abcdefgh"}... is not in config/cases'),
        (21 * "xyz", f'"{18 * "xyz"}xy... must not end in a pattern that stands 20 times'),
        (20 * "a", f'"{20 * "a"}" must not end in a pattern that stands 20 times or more'),
        (19 * "a", f'"{19 * "a"}" is not in config/cases'),
        (300 * "a", f'"{56 * "a"}... must be a file name without .yaml, of at most 64 letters'),
        ("../cases/small", '"../cases/small" must be a file name'),
        ("/etc/passwd", '"/etc/passwd" must be a file name'),
        ("a\nb", '"a\\nb" must be a file name'),
        ("", '"" must be a file name'),
        ("overview", '"overview" must be another name'),
    ],
)
def test_a_name_that_leads_to_no_file_is_refused(study, file, name, words):
    write(study / file, CONTENTS[file] | {"cases": [name]})
    changes = {"study": STUDY} if file == STUDY else {}
    assert problem_of(study, changes).startswith(f"{file}: cases[0]: {words}")


@pytest.mark.parametrize(
    ("key", "shown_as"),
    [
        (1000 * "k", f'"{56 * "k"}...'),
        ("two words", '"two words"'),
        ("a: b", '"a: b"'),
        ("a\nb", '"a\\nb"'),
        ("<<", '"<<"'),
        ("__use_yte__", "__use_yte__"),
        ("?expression", '"?expression"'),
    ],
)
def test_an_odd_key_is_shown_in_one_line(study, key, shown_as):
    for file in (CONFIG, CASE_FILE, ASSEMBLY_FILE, STUDY):
        (study / file).write_text(json.dumps(CONTENTS[file] | {key: {"a": 1}}), encoding="utf-8")
        line = problem_of(study, {"study": STUDY})
        write(study / file, CONTENTS[file])
        assert line.startswith(f"{file}: {shown_as}: is not a known key; there are: ")


def refused(study, file, changes):
    """What is said of a file with other keys."""
    write(study / file, CONTENTS[file] | changes)
    return problem_of(study).removeprefix(f"{file}: ")


SIDE = "the contact pairs of two_bolt on one side of the centre line and on it"


def test_more_regions_than_pairs_are_refused(study):
    # 138 pairs, 18 of them on the centre line; bands hold those on both sides of it alike
    assert refused(
        study, CASE_FILE, {"solve": solve("clusters=138", "regions=78", "regions=79")}
    ) == (f'solve[0].joints[2]: "regions=79" must have at most 78 regions, {SIDE}')
    assert refused(study, CASE_FILE, {"solve": solve("clusters=139")}) == (
        'solve[0].joints[0]: "clusters=139" must have at most 138 clusters, '
        "the contact pairs of two_bolt"
    )
    write(study / CASE_FILE, CASE)
    convergence = {"bases": [], "regions": [78, 79]}
    assert refused(study, CONFIG, {"convergence": convergence}) == (
        f"convergence.regions[1]: 79 must be at most 78, {SIDE}"
    )
    # they are compared in the enriched basis of a case, or not at all
    write(study / CASE_FILE, CASE | {"solve": solve("node-to-node")})
    load_study(study)


def solve(*joints):
    return [{"resonance": 1, "joints": list(joints)}]


def test_larger_bases_than_are_found_are_refused(study):
    small = {"ring_cells_across_width": 2, "ring_cells_along_bar": 2, "rings_head_to_cell_edge": 1}
    write(study / ASSEMBLY_FILE, ASSEMBLY | {"mesh": ASSEMBLY["mesh"] | small})
    # 54 pairs, 14 of them on the centre line
    mesh, _ = make(load_study(study).assemblies["two_bolt"], study)
    y = mesh["position"].sel(axis="y")
    assert (y >= 0).sum() == 34
    contact_adapted_basis = SETTINGS["contact_adapted_basis"] | {
        "free_modes": 2,
        "maximum_vectors": 90,
    }
    bases = {"bases": ["enriched-70", "enriched-71"]}
    of_what = f"must have at most 70 vectors: contact_adapted_basis.free_modes, and two for each of {SIDE}"  # noqa: E501
    changes = {"contact_adapted_basis": contact_adapted_basis, "convergence": bases}
    assert refused(study, CONFIG, changes) == (f'convergence.bases[1]: "enriched-71" {of_what}')
    write(
        study / CONFIG,
        SETTINGS | {"contact_adapted_basis": contact_adapted_basis, "convergence": {}},
    )
    assert (
        refused(study, CASE_FILE, {"modes": ["enriched-71"]})
        == f'modes[0]: "enriched-71" {of_what}'
    )


@pytest.mark.parametrize(
    ("place", "made"),
    [
        ("excitation.points[0]", lambda p: {"excitation": {"kind": "forces", "points": [p]}}),
        ("sensors[0]", lambda p: {"sensors": [p | {"name": "tip"}]}),
    ],
)
def test_a_point_in_the_support_is_refused(study, place, made):
    # four elements of 15 mm from the support to the lap
    point = {"y_mm": 0, "z_mm": 10, "direction": "z"}
    for x_mm in (0, 7.5):
        assert refused(study, CASE_FILE, made(point | {"x_mm": x_mm})) == (
            f"{place}.x_mm: {x_mm} is in the support, where no mode moves: must be more than 7.5 mm"
        )
    write(study / CASE_FILE, CASE | made(point | {"x_mm": 7.6}))
    load_study(study)


def test_an_assembly_that_nothing_holds_has_points_everywhere_and_no_support(study):
    write(study / ASSEMBLY_FILE, ASSEMBLY | {"support": "none"})
    point = {"x_mm": 0, "y_mm": 0, "z_mm": 10, "direction": "z"}
    write(study / CASE_FILE, CASE | {"sensors": [point | {"name": "end"}]})
    load_study(study)
    shaken = {"excitation": {"kind": "base", "direction": "z"}, "accelerations_m_per_s2": [1.0]}
    content = {key: value for key, value in CASE.items() if "forces" not in key} | shaken
    write(study / CASE_FILE, content)
    sentence = "must not be base: nothing is said to hold two_bolt"
    assert problem_of(study) == f'{CASE_FILE}: excitation.kind: "base" {sentence}'


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"outputs": ["tp"]}, 'outputs[0]: "tp" is no output of two_bolt; there are: output'),
        (
            {"excitation": {"kind": "inputs", "inputs": [{"name": "shaker"}]}},
            'excitation.inputs[0].name: "shaker" is no input of two_bolt; there are: excitation',
        ),
    ],
)
def test_places_that_the_assembly_does_not_name_are_refused(study, changes, problem):
    assert refused(study, CASE_FILE, CASE | changes) == problem


# ---- through the workflow


@pytest.fixture
def copied(project, tmp_path):
    """A copy of the project before it is run."""
    folder = tmp_path / "project"
    shutil.copytree(project, folder, ignore=shutil.ignore_patterns("results", ".snakemake"))
    return folder


def test_a_wrong_study_stops_before_any_job_and_code_in_it_is_not_run(copied, monkeypatch):
    code = "__use_yte__: true\n__definitions__: ['import pathlib; pathlib.Path(\"ran\").touch()']\n"
    (copied / CONFIG).write_text(f"{code}cases: [small]\n", encoding="utf-8")
    (copied / STUDY).write_text(f"{code}fitting: {{initial_guess: 1}}\n", encoding="utf-8")
    write(copied / CASE_FILE, CASE | {"preload_N": "much"})
    output = said(copied, "--config", f"study={STUDY}")
    assert f"{STUDY}: __use_yte__: is not a known key; there are: cases, " in output
    assert (
        f"{STUDY}: fitting.initial_guess: is not a known key; did you mean initial_guesses? "
        "there are: initial_guesses, load_fractions\n"
    ) in output
    assert f'{CASE_FILE}: preload_N: "much" must be a number\n' in output
    assert f"{CONFIG}: __use_yte__: is not a known key; there are: cases, " in said(copied)
    assert not (copied / "ran").exists()
    # as it would be by Snakemake's own reader
    monkeypatch.chdir(copied)
    for file in (CONFIG, STUDY):
        load_configfile(file)
        assert (copied / "ran").exists()
        (copied / "ran").unlink()


def test_a_study_file_is_not_given_as_configfile(copied):
    assert "--configfile is not for this study: name the file by --config study=FILE" in said(
        copied, "--configfile", CONFIG
    )


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "cannot be read: No such file or directory"),
        ("", "must have a column case"),
        ("name\nsmall\n", "must have a column case"),
        (b"case\n\xff\n", "cannot be read as CSV: "),
    ],
)
def test_an_unsuitable_index_of_the_source_is_a_line(tmp_path, content, words):
    if content is not None:
        data = content if isinstance(content, bytes) else content.encode()
        (tmp_path / CASE_STUDIES).write_bytes(data)
    with pytest.raises(ConfigError) as refused:
        name_case_studies(tmp_path)
    (line,) = refused.value.problems
    assert line.startswith(f"{tmp_path / CASE_STUDIES}: {words}")


def test_an_empty_index_of_the_source_stops_before_any_job(copied):
    source = copied / "resources/source"
    source.mkdir(parents=True)
    (source / INDEX).touch()
    assert f"resources/source/{INDEX}: must have a column file" in said(copied)
    (source / INDEX).write_text("file,columns\n", encoding="utf-8")
    assert f"resources/source/{CASE_STUDIES}: cannot be read: No such file" in said(copied)
    (source / CASE_STUDIES).touch()
    assert f"resources/source/{CASE_STUDIES}: must have a column case" in said(copied)


def test_names_that_snakemake_refuses_are_refused_before_it_does(copied):
    """The same names, and one repetition less, which Snakemake takes."""
    names = [20 * "a", 21 * "xyz"]
    for name in (*names, 19 * "a"):
        write(copied / f"config/cases/{name}.yaml", CASE)
    settings = SETTINGS | {"cases": ["small", *names]}
    write(copied / CONFIG, settings)
    output = said(copied)
    for index, name in enumerate(names, start=1):
        assert f'{CONFIG}: cases[{index}]: "{name}'[:60] in output
        assert PeriodicityDetector().is_periodic(name)
    assert output.count("must not end in a pattern that stands 20 times or more") == len(names)
    write(copied / CONFIG, settings | {"cases": ["small", 19 * "a"]})
    ran = snakemake(copied, "--dry-run", "--quiet", "all")
    assert ran.returncode == 0, ran.stderr


def said(folder, *options):
    """What a run says that is refused, whose output without jobs goes to two places."""
    ran = snakemake(folder, "--dry-run", *options)
    assert ran.returncode != 0
    output = ran.stdout + ran.stderr
    assert "Traceback" not in output
    assert "rule " not in output
    return output


def test_a_study_file_and_the_command_line_change_what_is_planned(copied):
    write(copied / STUDY, {"convergence": {"bases": []}})
    ran = snakemake(copied, "--dry-run", "--config", f"study={STUDY}", "convergence={regions: []}")
    assert ran.returncode == 0, ran.stderr
    assert "solve_response" in ran.stdout + ran.stderr
    for rule in ("find_peaks", "tabulate_divisions", "find_patterns"):
        assert rule not in ran.stdout + ran.stderr
