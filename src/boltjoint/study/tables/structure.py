"""Tables of natural frequencies and contact."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from boltjoint.names import Preload


def tabulate_frequencies(modes: Mapping[str, xr.Dataset]) -> pd.DataFrame:
    """Natural frequencies of the bending modes without contact, by assembly.

    Rigid-body modes, at 0 Hz, are counted alone, in a column where there are any.

    Parameters
    ----------
    modes
        ``modes.nc`` of each assembly by its name.
    """
    tables, rigid = [], {}
    for name, dataset in modes.items():
        frequency = dataset["natural_frequency"].to_numpy()
        elastic = frequency[frequency > 0]
        rigid[name] = frequency.size - elastic.size
        number = np.arange(1, elastic.size + 1)
        columns = {"assembly": name, "bending_mode": number, "frequency_Hz": elastic}
        tables.append(pd.DataFrame(columns))
    table = pd.concat(tables)
    if any(rigid.values()):
        table["rigid_body_modes"] = table["assembly"].map(rigid)
    return table


def tabulate_families(modes: Mapping[str, xr.Dataset]) -> pd.DataFrame:
    """Natural frequencies of the modes of all families without contact, by assembly.

    Parameters
    ----------
    modes
        ``modes.nc`` of a basis ``all-N`` of each assembly by its name.
    """
    tables = []
    for name, dataset in modes.items():
        frequency, family = (
            dataset[variable].to_numpy() for variable in ("natural_frequency", "candidate_family")
        )
        number = np.arange(1, frequency.size + 1)
        family = ["rigid body"] * (frequency.size - family.size) + family.tolist()
        columns = {"assembly": name, "mode": number, "family": family, "frequency_Hz": frequency}
        tables.append(pd.DataFrame(columns))
    return pd.concat(tables)


def tabulate_contact(preloads: Mapping[tuple[str, str], xr.Dataset]) -> pd.DataFrame:
    """Loads and gaps of the contact surface, by assembly and preload.

    Parameters
    ----------
    preloads
        ``preload.nc`` of each pair of assembly name and preload (``names.Preload``) [N].
    """
    rows = []
    for (assembly, newton), dataset in preloads.items():
        load = dataset["normal_load"].to_numpy()
        of_bolts = Preload(newton).of_bolts
        # where loads are given, nothing tells bolts
        count = dataset.sizes["bolt"]
        bolts = np.broadcast_to(of_bolts, count).sum() if count else np.nan
        pressure = load / dataset["area"].to_numpy()
        rows.append(
            {
                "assembly": assembly,
                "preload_N": newton if isinstance(of_bolts, tuple) else of_bolts,
                "pairs": load.size,
                "loaded_pairs": int(np.count_nonzero(load)),
                "normal_load_N": load.sum(),
                "bolt_load_N": bolts,
                "load_difference_relative": load.sum() / bolts - 1,
                "largest_load_N": load.max(),
                "largest_pressure_MPa": pressure.max() / 1e6,
                "largest_gap_um": dataset["gap"].to_numpy().max() * 1e6,
                "shank_shortening_um": float(dataset["shank_shortening"].mean()) * 1e6,
                "newton_iterations": int(dataset["iterations"]),
            }
        )
    return pd.DataFrame(rows)
