"""JSON schemas of the YAML files, by which editors complete and check them."""

import json
from pathlib import Path

from boltjoint.config.assembly import Assembly
from boltjoint.config.case import Case
from boltjoint.config.entries import Entry
from boltjoint.config.matrices import Matrices
from boltjoint.config.settings import Settings
from boltjoint.config.sweep import Sweep

SCHEMAS: dict[str, type[Entry]] = {
    "config": Settings,
    "assembly": Assembly,
    "matrices": Matrices,
    "case": Case,
    "sweep": Sweep,
}


def schema_text(model: type[Entry]) -> str:
    """The JSON schema of a YAML file, as the text that is kept in config/schemas."""
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **model.model_json_schema(),
    }
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


def write_schemas(folder: str | Path) -> None:
    """Write the JSON schemas of the YAML files into a folder."""
    for name, model in SCHEMAS.items():
        path = Path(folder) / f"{name}.schema.json"
        path.write_text(schema_text(model), encoding="utf-8")
