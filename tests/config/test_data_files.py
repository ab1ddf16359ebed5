"""Tables of designs and maps of a gap: their names, what they may be, and their hashes."""

import os

import pytest
from small_study import ASSEMBLY, CASE, SETTINGS, SWEEP, write

from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError

SWEEP_FILE, ASSEMBLY_FILE = "config/sweeps/swept.yaml", "config/assemblies/two_bolt.yaml"
TABLE, MAP = "config/sweeps/designs.csv", "config/assemblies/measured.csv"
DESIGNS = "loss_factor\n0.004\n0.005\n"
FLAT = "x_mm,y_mm,gap_um\n" + "".join(f"{x},{y},0\n" for x in (-40, 40) for y in (-10, 10))
SWEPT = {key: value for key, value in SWEEP.items() if key != "vary"}
NAME = "must be a file in the folder that holds config/, as config/designs.csv, without { } : \\ "
NAME += "and names that begin with a point"


@pytest.fixture
def study(tmp_path):
    """A study with a table and a map, in a folder beside which other files may lie."""
    folder = tmp_path / "study"
    for file, text in {TABLE: DESIGNS, MAP: FLAT}.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(text, encoding="utf-8")
    write(folder / "config/config.yaml", SETTINGS | {"sweeps": ["swept"], "convergence": {}})
    write(folder / "config/cases/small.yaml", CASE | {"modes": ["free-2"], "solve": SOLVE})
    name_files(folder, TABLE, MAP)
    load_study(folder)
    return folder


SOLVE = [{"resonance": 1, "joints": ["node-to-node"]}]


def name_files(folder, table=TABLE, gap_map=MAP):
    write(folder / SWEEP_FILE, SWEPT | {"design": {"kind": "table", "file": table}})
    write(folder / ASSEMBLY_FILE, ASSEMBLY | {"contact": {"gap_um": gap_map}})


def problems_of(folder):
    with pytest.raises(ConfigError) as caught:
        load_study(folder)
    assert all(line.isprintable() and len(line) < 500 for line in caught.value.problems)
    return list(caught.value.problems)


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("config/sweeps/{sweep}.csv", '"config/sweeps/{sweep}.csv"'),
        ("{assembly}.csv", '"{assembly}.csv"'),
        ("/etc/passwd", '"/etc/passwd"'),
        ("../designs.csv", '"../designs.csv"'),
        ("config/../../designs.csv", '"config/../../designs.csv"'),
        (".snakemake/designs.csv", '".snakemake/designs.csv"'),
        ("./designs.csv", '"./designs.csv"'),
        ("config//designs.csv", '"config//designs.csv"'),
        ("https://designs.csv", '"https://designs.csv"'),
        ("a\\b.csv", '"a\\\\b.csv"'),
        ("", '""'),
    ],
)
def test_a_name_is_that_of_a_file_in_the_folder(study, name, shown):
    name_files(study, table=name)
    assert problems_of(study) == [f"{SWEEP_FILE}: design.file: {shown} {NAME}"]
    name_files(study, gap_map=name)
    assert problems_of(study) == [f"{ASSEMBLY_FILE}: contact.gap_um: {shown} {NAME}"]


@pytest.mark.parametrize("name", ["designs of may, 2nd.csv", "config/µ/[1]=~(a).csv", "mätze"])
def test_other_names_are_taken(study, name):
    for text, key in ((DESIGNS, "table"), (FLAT, "gap_map")):
        (study / name).parent.mkdir(exist_ok=True)
        (study / name).write_text(text, encoding="utf-8")
        name_files(study, **{key: name})
        load_study(study)


def link(target):
    return lambda path: path.symlink_to(target)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (link("/dev/zero"), "lies outside the folder of the study"),
        (link("/etc/passwd"), "lies outside the folder of the study"),
        (link("../../../designs.csv"), "lies outside the folder of the study"),
        (os.mkfifo, "is no regular file"),
        (lambda path: path.touch() or os.truncate(path, 10**11), "is larger than 100000000 bytes"),
        (
            lambda path: path.write_bytes(DESIGNS.encode("utf-16")),
            "is not text in UTF-8: save it as CSV in UTF-8",
        ),
        (lambda path: path.mkdir(), "cannot be read: Is a directory"),
    ],
)
def test_a_file_is_a_regular_one_in_the_folder(study, make, sentence):
    (study.parent / "designs.csv").write_text(DESIGNS, encoding="utf-8")
    (study / TABLE).unlink()
    make(study / TABLE)
    assert problems_of(study) == [f"{TABLE}: {sentence}"]
    (study / MAP).unlink()
    (study / TABLE).rename(study / MAP)
    (study / TABLE).write_text(DESIGNS, encoding="utf-8")
    (line,) = problems_of(study)
    sentence = sentence.replace(": Is a directory", " (Is a directory)")
    assert line == (
        f'{ASSEMBLY_FILE}: contact.gap_um: "{MAP}" {sentence}: must be a CSV file, seen from the '
        "folder of config/"
    )


@pytest.mark.parametrize("file", ["config/config.yaml", "config/cases/small.yaml", SWEEP_FILE])
def test_yaml_files_are_regular_ones_in_the_folder(study, file):
    content = (study / file).read_bytes()
    (study / file).unlink()
    os.mkfifo(study / file)
    assert problems_of(study) == [f"{file}: is no regular file"]
    (study / file).unlink()
    (study / file).symlink_to("/etc/passwd")
    assert problems_of(study) == [f"{file}: lies outside the folder of the study"]
    # a study file of the command line may lie anywhere, as what is given there is trusted
    (study / file).unlink()
    (study / file).write_bytes(content)
    (study.parent / "mine.yaml").write_text("fitting: {initial_guesses: 2}\n", encoding="utf-8")
    assert load_study(study, {"study": "../mine.yaml"}).fitting.initial_guesses == 2


def test_the_hash_of_a_file_is_that_of_its_content(study):
    first = load_study(study).hashes
    assert set(first) == {TABLE, MAP}
    os.utime(study / TABLE)
    assert load_study(study).hashes == first
    (study / TABLE).write_text(DESIGNS + "0.006\n", encoding="utf-8")
    second = load_study(study)
    assert second.hashes[MAP] == first[MAP]
    assert second.hashes[TABLE] != first[TABLE]
    # pages hold no hashes, so that another table leaves those alone that show nothing of it
    assert "hashes" not in second.model_dump()
