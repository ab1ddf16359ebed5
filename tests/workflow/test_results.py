"""What the small study has made."""

import re

import pandas as pd
import pytest
import xarray as xr
from small_study import CASES, CHECKS, RESPONSES

from boltjoint.config.study import load_study
from boltjoint.report.displays import DISPLAYS
from boltjoint.study.artefact_list import Contents


def test_every_result_is_there(finished):
    results = finished / "results"
    tables = {path.name for path in (results / "tables").iterdir()}
    assert {
        "contact.csv",
        "accuracy_small_free-2.csv",
        "times_small_free-2.html",
        "accuracy_small_enriched-8.csv",
        "regions_small_free-2_clusters=2.csv",
        "elements_small_free-2_clusters=2_harmonic=2.csv",
        "harmonic_peaks_small_enriched-8.csv",
        "harmonics_small_free-2.csv",
        "steady_states_small_enriched-8.csv",
        "patterns_two_bolt.csv",
        "bases_variable.csv",
        "divisions_small_enriched-8.csv",
        "reductions_small_enriched-8.csv",
        "fits_small_free-2.csv",
    } <= tables
    for case, count in RESPONSES.items():
        assert len(list((results / "cases" / case).rglob("response.nc"))) == count
        assert len(list((results / "cases" / case).rglob("timing.csv"))) == count
        assert len(list((results / "cases" / case).rglob("check.csv"))) == CHECKS[case]
    assert (results / "assemblies/two_bolt/preload=10000/preload.nc").exists()
    assert list((results / "figures").glob("response_small_*.svg"))


def test_whatever_is_written_is_asked_for_so_that_it_is_made_again_once_lost(finished):
    written = {
        path.relative_to(finished).as_posix()
        for path in (finished / "results").rglob("*")
        if path.is_file() and path.relative_to(finished).parts[1] not in ("logs", "benchmarks")
    }
    assert written == set(Contents(load_study(finished), DISPLAYS).files())


@pytest.mark.parametrize("case", CASES)
def test_tables_hold_the_responses(finished, case):
    tables = {
        path.stem: pd.read_csv(path)
        for path in (finished / "results/tables").glob(f"accuracy_{case}_*.csv")
    }
    rows = RESPONSES[case] * len(CASES[case]["forces_N"])
    assert sum(map(len, tables.values())) == rows
    table = tables[f"accuracy_{case}_free-2"]
    where = finished / f"results/cases/{case}/free-2/regions=2/linear/resonance=1/response.nc"
    with xr.open_dataset(where) as response:
        row = table.query("joint == 'regions=2' and coordinates == 'linear' and force_N == 20")
        # the table is written with nine digits
        assert row["peak_frequency_Hz"].item() == pytest.approx(
            float(response["peak_frequency"][-1]), rel=1e-8
        )


def test_models_of_the_same_joint_agree(finished):
    def peaks(table, joint, coordinates):
        found = pd.read_csv(finished / f"results/tables/accuracy_small_{table}.csv")
        rows = found.query("joint == @joint and coordinates == @coordinates")
        assert rows["complete"].all()
        return rows[["peak_frequency_Hz", "peak_mm_per_N"]].to_numpy()

    # the table is interpolated to 1e-6 of the force
    every, tabulated = (
        peaks("free-2", joint, "linear") for joint in ("regions=2", "regions=2/table")
    )
    assert tabulated == pytest.approx(every, rel=1e-5)
    # one complex mode leaves out what the others do dynamically, the backbone what they do at all
    linear, complex_mode, backbone = (
        peaks("enriched-8", "node-to-node", coordinates)
        for coordinates in ("linear", "complex-rdnm-1", "backbone")
    )
    assert complex_mode == pytest.approx(linear, rel=0.01)
    assert backbone == pytest.approx(linear, rel=0.01)
    # two modes without contact are too stiff for it
    assert (linear[:, 0] < 0.96 * peaks("free-2", "clusters=2/harmonic=2", "linear")[:, 0]).any()


#: products and quotients of whole powers, as UDUNITS reads them
SYMBOL = "(m|kg|s|N|Hz|Pa|J|rad)[2-9]?"
UNITS = re.compile(rf"1|{SYMBOL}( {SYMBOL})*(/{SYMBOL})?")
#: of modes and modal coordinates, which it does not know
ROOTS = {"kg^-1/2", "kg^1/2", "kg^1/2 m", "m J^-1/2", "Pa kg^-1/2 m^-1"}


def test_files_tell_their_units_and_parameters(finished):
    for path in (finished / "results").rglob("*.nc"):
        with xr.open_dataset(path) as dataset:
            assert dataset.attrs["boltjoint_version"]
            assert "parameters" in dataset.attrs
            assert {"Conventions", "title", "history"} <= set(dataset.attrs)
            for name, variable in dataset.variables.items():
                if variable.dtype.kind not in "UOST":
                    units = variable.attrs.get("units", "")
                    assert units in ROOTS or UNITS.fullmatch(units), (path, name)
