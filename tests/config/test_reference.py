"""The tables of keys in config/README.md are made from the sections."""

import re
import shutil
import subprocess
import sys

import pytest
from mutations import ROOT

from boltjoint.config.reference import BEGIN, END, SCHEMAS, reference, schema_text

README = (ROOT / "config/README.md").read_text(encoding="utf-8")


def test_the_readme_holds_the_tables():
    assert README.split(BEGIN)[1].split(END)[0] == reference(), "run: make reference"


def test_a_command_writes_tables_and_schemas(tmp_path):
    shutil.copytree(ROOT / "config", tmp_path / "config")
    (tmp_path / "config/README.md").write_text(f"before\n{BEGIN}{END}after\n", encoding="utf-8")
    for path in (tmp_path / "config/schemas").iterdir():
        path.unlink()
    command = [sys.executable, "-m", "boltjoint.config.reference"]
    subprocess.run(command, cwd=tmp_path, check=True)
    text = (tmp_path / "config/README.md").read_text(encoding="utf-8")
    assert text == f"before\n{BEGIN}{reference()}{END}after\n"
    for name, model in SCHEMAS.items():
        written = (tmp_path / f"config/schemas/{name}.schema.json").read_text(encoding="utf-8")
        assert written == schema_text(model)


@pytest.mark.parametrize(
    "row",
    [
        "| `time_samples` | Time samples of a period .* | 1 | `256` | whole number ≥ 8 |",
        "| `tolerance` | Residual .* | 1 | `1e-9` | number ≥ 1e-15, < 1 |",
        "| `load_fractions` | .* | 1 | `[0.3, 0.6, 0.9]` | list of 3: number > 0, < 1, each once |",
        "| `basis_update` | .* |  | `implicit` | `implicit`, `lagged` |",
        "| `quasi_static_correction` | .* |  | `true` | `true`, `false` |",
        "| `cases` | .* |  | required | list: .*, not `overview`, .*, each once |",
        "| `preload_N` | Preload of each bolt;.* | N | none | number > 0 |",
        "| `bolt_preloads_N` | .* | N | none | names of bolts, each with a number ≥ 0 |",
        "| `penalty_N_per_m3` | .* | N/m³ | `1e15` | number > 0 |",
        "| `poissons_ratio` | .* | 1 | required | number ≥ 0, < 0.5 |",
        "| `ring_cells_across_width` | .* | 1 | required | whole number ≥ 2, multiple of 2 |",
        "| `window_Hz` | .* | Hz | none | list of 2: number > 0 |",
        "| `fitting` | .* |  | see below | keys below |",
    ],
)
def test_a_row_has_meaning_unit_default_and_limits(row):
    pattern = ".*".join(map(re.escape, row.split(".*")))
    assert re.search(f"^{pattern}$", reference(), re.MULTILINE)


def test_every_key_has_a_meaning_and_stands_below_its_section():
    rows = re.findall(r"^\| `(\w+)` \| ([^|]*) \|", reference(), re.MULTILINE)
    assert len(rows) > 80
    assert [key for key, meaning in rows if len(meaning.split()) < 2] == []
    heads = re.findall(r"^\*\*(\w+)\*\*(?: with `(law: \w+)`)?", reference(), re.MULTILINE)
    for section in (("solver", ""), ("contact", "law: constant"), ("contact", "law: variable")):
        assert section in heads
