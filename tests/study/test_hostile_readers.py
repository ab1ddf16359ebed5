"""Readers of files and tables of results refuse by a ``ValueError`` whatever they cannot use."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hostile_arguments import assert_refused
from measured_bar import calibration_of_truth, prediction_of_truth
from small_study import CASE, write_config

from boltjoint import checksums, csv_files, regular_file
from boltjoint.config import csv_table, gap_map, measured_tables, strict_yaml
from boltjoint.config.distributions import Linear
from boltjoint.config.sampling import Saltelli
from boltjoint.config.study import load_study
from boltjoint.reproduction.case_studies import name_case_studies, name_tables, name_timed_joints
from boltjoint.reproduction.published import Published
from boltjoint.structure import elasticity
from boltjoint.study.designs import list_designs, values_of
from boltjoint.study.tables import (
    accuracy,
    calibration,
    harmonic_peaks,
    html,
    meshes,
    sobol_indices,
    sweeps,
)

TEXTS = {
    "table.csv": "a,b\n1,2\n",
    "gap.csv": "x_mm,y_mm,gap_um\n0,0,1\n1,0,1\n0,1,2\n",
    "backbone.csv": "mode,displacement_mm,frequency_Hz,damping_ratio\n1,0.1,100,0.01\n",
    "sine.csv": "level,displacement_mm,frequency_Hz,force_N\n1,0.1,100,2\n",
    "keys.yaml": "a: 1\nb: [1, {c: 2}]\n",
    "case_studies.csv": "case,assembly,contact_law,contact_nodes\nmine,one,constant,3\n",
    "tables.csv": "table,case,kind,joint,file\n3.1,mine,times,node-to-node,times\n",
}
VARY = {
    "preload_N": (8e3, 12e3),
    "loss_factor": Linear(kind="linear", lowest=1e-3, highest=1e-2),
}
SALTELLI = Saltelli(kind="saltelli", number=4)
DESIGNS = list_designs(VARY, SALTELLI, CASE)
OF_LEVELS = ("design", "force")
PEAKS = 70 + np.linspace(0, 1, 2 * DESIGNS.sizes["design"]).reshape(-1, 2)
SWEEP = DESIGNS.assign(
    {
        "force_level": ("force", [1.0, 10.0]),
        "peak_frequency": (OF_LEVELS, PEAKS),
        "peak_amplitude": (OF_LEVELS, 1e-5 * PEAKS),
        "response_amplitude": ((*OF_LEVELS, "frequency"), PEAKS[..., None] * [1.0, 2.0, 1.0]),
        "natural_frequency": (("design", "amplitude"), PEAKS),
        "damping_ratio": (("design", "amplitude"), PEAKS),
        "amplitude": ("amplitude", [1e-6, 1e-3]),
    }
)
OF_SENSORS = ("force", "sensor")
RESPONSE = xr.Dataset(
    {
        "force_level": ("force", [1.0, 10.0]),
        "excitation_force": ("solution", [1.0, 10.0]),
        "complete": ("force", [1, 0]),
        "reason": ("force", ["", "no convergence"]),
        "peak_frequency": ("force", [70.0, np.nan]),
        "peak_amplitude": ("force", [1e-5, np.nan]),
        "sensor_peak_frequency": (OF_SENSORS, [[70.0], [np.nan]]),
        "sensor_peak_amplitude": (OF_SENSORS, [[1e-6], [np.nan]]),
        "peak_harmonics": ("force", [3.0, np.nan]),
        "harmonic_peak_frequency": (("force", "harmonics"), [[70.0, 70.1], [np.nan, np.nan]]),
        "harmonic_peak_amplitude": (("force", "harmonics"), [[1e-5, 2e-5], [np.nan, np.nan]]),
        "peak_frequency_truncation_error": ("force", [1e-4, np.nan]),
        "peak_amplitude_truncation_error": ("force", [1e-4, np.nan]),
        "superharmonic_order": ("force", [3, 0]),
        "superharmonic_frequency": ("force", [210.0, np.nan]),
        "superharmonic_share": ("force", [0.1, np.nan]),
    },
    {"sensor": ["end"], "harmonics": [1, 3]},
)
CALIBRATION = calibration_of_truth()
PREDICTION = prediction_of_truth()
CUBE = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])


def read_table(text, file):
    return csv_table.CsvTable(text, file).columns()


#: valid calls: the function, and its arguments by name
CALLS = {
    "read_bytes": (
        regular_file.read_bytes,
        {"path": "table.csv", "largest": 1000, "folder": "."},
    ),
    "read_file": (csv_table.read_file, {"path": "table.csv", "folder": "."}),
    "CsvTable": (read_table, {"text": TEXTS["table.csv"], "file": "table.csv"}),
    "read_gap_map": (gap_map.read_gap_map, {"text": TEXTS["gap.csv"], "file": "gap.csv"}),
    "load_gap_map": (gap_map.load_gap_map, {"path": "gap.csv"}),
    "read_mapping": (strict_yaml.read_mapping, {"path": "keys.yaml", "folder": "."}),
    "parse_mapping": (strict_yaml.parse_mapping, {"text": TEXTS["keys.yaml"]}),
    "load_study": (
        load_study,
        {"folder": "study", "changes": {"cases": ["small"]}, "published": None, "before": False},
    ),
    "name_case_studies": (name_case_studies, {"folder": "."}),
    "name_tables": (name_tables, {"index": "tables.csv"}),
    "name_timed_joints": (name_timed_joints, {"index": "tables.csv"}),
    "Published": (Published, {"folder": ".", "case": "mine"}),
    "append": (checksums.append, {"path": "table.csv"}),
    "write_text": (checksums.write_text, {"path": "written.txt", "text": "a"}),
    "read_text": (checksums.read_text, {"path": "table.csv"}),
    "write": (
        html.write,
        {
            "table": pd.DataFrame({"force_N": [1.0]}),
            "csv": "written.csv",
            "page": "written.html",
            "title": "Forces",
        },
    ),
    "csv_files.write": (csv_files.write, {"table": pd.DataFrame({"a": [1.0]}), "path": "all.csv"}),
    "write_rounded": (csv_files.write_rounded, {"table": pd.DataFrame(), "path": "nine.csv"}),
    "csv_files.read": (csv_files.read, {"path": "tables.csv", "dtype": {"table": str}}),
    "list_designs": (
        list_designs,
        {
            "vary": VARY,
            "design": SALTELLI,
            "case": CASE,
            "variants": [{"values": {}, "reason": ""}],
            "table": None,
        },
    ),
    "values_of": (values_of, {"designs": DESIGNS}),
    "tabulate_statistics": (sweeps.tabulate_statistics, {"sweep": SWEEP}),
    "tabulate_extremes": (sweeps.tabulate_extremes, {"sweep": SWEEP}),
    "tabulate_sensitivity": (sobol_indices.tabulate_sensitivity, {"sweep": SWEEP}),
    "response_quantiles": (sweeps.response_quantiles, {"sweep": SWEEP, "shares": [0.1, 0.5]}),
    "backbone_quantiles": (
        sweeps.backbone_quantiles,
        {"sweep": SWEEP, "name": "damping_ratio", "shares": [0.1, 0.5]},
    ),
    "tabulate_convergence": (
        meshes.tabulate_convergence,
        {"sweep": SWEEP, "size": np.linspace(1, 2, DESIGNS.sizes["design"]), "amplitudes": 2},
    ),
    "tabulate_harmonic_peaks": (harmonic_peaks.tabulate_harmonic_peaks, {"response": RESPONSE}),
    "tabulate_parameters": (calibration.tabulate_parameters, {"calibration": CALIBRATION}),
    "tabulate_correlation": (calibration.tabulate_correlation, {"calibration": CALIBRATION}),
    "tabulate_residuals": (calibration.tabulate_residuals, {"calibration": CALIBRATION}),
    "tabulate_prediction": (calibration.tabulate_prediction, {"prediction": PREDICTION}),
    "read_backbone_table": (
        measured_tables.read_backbone_table,
        {"text": TEXTS["backbone.csv"], "file": "backbone.csv", "rows": {"mode": 1}},
    ),
    "read_response_table": (
        measured_tables.read_response_table,
        {"text": TEXTS["sine.csv"], "file": "sine.csv", "rows": {"level": 1}},
    ),
    "tabulate_sensors": (accuracy.tabulate_sensors, {"response": RESPONSE}),
    "peak_of_level": (accuracy.peak_of_level, {"response": RESPONSE, "level": 0}),
    "smallest_jacobian": (
        elasticity.smallest_jacobian,
        {"coordinate": CUBE, "connectivity": np.arange(8)[None]},
    ),
}
#: calls of each, of which every one has another argument
NUMBER = 60


@pytest.mark.parametrize("name", CALLS)
def test_hostile_arguments_are_refused_by_a_value_error(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_config(Path("study"))
    for file, text in TEXTS.items():
        Path(file).write_text(text)
    assert_refused(*CALLS[name], name, NUMBER)
