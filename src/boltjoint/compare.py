"""How far is one answer from another, and what did it cost? The tables of a study."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from boltjoint import joint as joints
from boltjoint.friction import states
from boltjoint.names import REFERENCE, parse_joint
from boltjoint.published import Published


def tabulate_frequencies(modes: Mapping[str, xr.Dataset], published: Published) -> pd.DataFrame:
    """Natural frequencies of the bending modes without contact, by assembly.

    Parameters
    ----------
    modes
        ``modes.nc`` of each assembly by its name.
    published
        The source's tables.
    """
    ours = pd.concat(
        pd.DataFrame(
            {
                "assembly": name,
                "bending_mode": np.arange(1, dataset.sizes["mode"] + 1),
                "frequency_Hz": dataset["natural_frequency"].to_numpy(),
            }
        )
        for name, dataset in modes.items()
    )
    printed = published.natural_frequencies().rename(columns={"frequency_Hz": "published_Hz"})
    table = ours.merge(printed, how="left", on=["assembly", "bending_mode"])
    table["difference_percent"] = 100 * (table["frequency_Hz"] / table["published_Hz"] - 1)
    return table


def tabulate_contact(
    preloads: Mapping[tuple[str, float], xr.Dataset], published: Published
) -> pd.DataFrame:
    """What the bolts do to the contact surface, by assembly and preload per bolt [N].

    Parameters
    ----------
    preloads
        ``preload.nc`` of each pair of assembly name and preload.
    published
        The source's tables.
    """
    printed = published.contact_nodes().set_index(["assembly", "contact_law"])["contact_nodes"]
    rows = []
    for (assembly, newton), dataset in preloads.items():
        load = dataset["normal_load"].to_numpy()
        bolts = newton * dataset.sizes["bolt"]
        pressure = load / dataset["area"].to_numpy()
        rows.append(
            {
                "assembly": assembly,
                "preload_N": newton,
                "pairs": load.size,
                "published_pairs": printed.get((assembly, "variable")),
                "loaded_pairs": int(np.count_nonzero(load)),
                "published_loaded_pairs": printed.get((assembly, "constant")),
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


def tabulate_regions(joint: xr.Dataset) -> pd.DataFrame:
    """Elements, load and stiffness of each region of a joint, from its ``joint.nc``.

    Where the normal load varies, open pairs have elements as well. Stiffnesses are those of the
    elements that carry load in the assembled state, which alone act in small motion.
    """
    law = joints.from_dataset(joint).law
    region, slip_force = law.point_of_element, law.slip_force
    loaded = slip_force > 0
    x = joint["element_position"].sel(axis="x").to_numpy() * 1e3
    columns = {
        "region": region + 1,
        "x": x,
        "loaded": loaded,
        "slip": slip_force,
        "tangential": law.tangential_stiffness * loaded / 1e6,
    }
    sums = {
        "loaded_elements": ("loaded", "sum"),
        "from_x_mm": ("x", "min"),
        "to_x_mm": ("x", "max"),
        "slip_force_N": ("slip", "sum"),
        "stiffness_kN_per_mm": ("tangential", "sum"),
    }
    if "normal" in law.directions:
        columns["normal"] = law.normal_stiffness * loaded / 1e6
        sums["normal_stiffness_kN_per_mm"] = ("normal", "sum")
    table = pd.DataFrame(columns).groupby("region").agg(elements=("x", "size"), **sums)
    table["share_of_load_percent"] = 100 * table["slip_force_N"] / slip_force.sum()
    return table.reset_index()


def tabulate_elements(joint: xr.Dataset, name: str, published: Published) -> pd.DataFrame:
    """Fitted elements of a reduced joint beside the published ones, in the order they slip.

    The slip force is that of the assembled state: mu times the normal load that the element then
    has. Where that load varies, normal stiffnesses are listed too; the source takes them equal to
    the tangential ones.

    Parameters
    ----------
    joint
        ``joint.nc`` of a reduced joint.
    name
        The joint's name, ``regions=N/elements=M``.
    published
        The source's tables.
    """
    law = joints.from_dataset(joint).law
    ours = {"k_kN_per_mm": law.tangential_stiffness / 1e6, "slip_force_N": law.slip_force}
    if "normal" in law.directions:
        ours["normal_k_kN_per_mm"] = law.normal_stiffness / 1e6
    table = _in_order_of_slip(law.point_of_element + 1, ours)
    printed = published.parameters(name)
    if printed.empty:
        return table
    theirs = _in_order_of_slip(
        printed["joint"].to_numpy(),
        {"k_kN_per_mm": printed["k_kN_per_mm"], "slip_force_N": printed["mu_n_N"]},
    ).rename(columns=lambda column: f"published_{column}" if column in ours else column)
    table = table.merge(theirs, how="left", on=["region", "element"])
    table["k_ratio"] = table["k_kN_per_mm"] / table["published_k_kN_per_mm"]
    table["slip_force_ratio"] = table["slip_force_N"] / table["published_slip_force_N"]
    return table.assign(source_table=printed["source_table"].iloc[0])


def tabulate_states(
    responses: Mapping[tuple[str, str, int], xr.Dataset], of_joint: Mapping[str, xr.Dataset]
) -> pd.DataFrame:
    """How many elements stick, slip and separate at the peaks, and what load they carry at rest.

    Parameters
    ----------
    responses
        ``response.nc`` by joint, coordinates and resonance.
    of_joint
        ``joint.nc`` of each of these joints by its name.

    Returns
    -------
    DataFrame
        A row for each response and force level. For each contact state there is its share of the
        number of elements, and of the normal load of the assembled state, which makes joints with
        many elements and with few comparable. Shares are empty where no peak was found.

    Raises
    ------
    ValueError
        If a response and its joint differ in their number of elements.
    """
    of_load = {name: _share_of_load(joint) for name, joint in of_joint.items()}
    rows = []
    for (joint, coordinates, resonance), response in responses.items():
        found = response["contact_state"].transpose("force", "element").to_numpy()
        load = of_load[joint]
        if load.size != found.shape[1]:
            raise ValueError(
                f"the response of {joint} has {found.shape[1]} elements, the joint {load.size}"
            )
        for level, state in enumerate(found):
            row = {
                "joint": joint,
                "coordinates": coordinates,
                "resonance": resonance,
                "force_N": float(response["force_level"][level]),
                "peak_frequency_Hz": float(response["peak_frequency"][level]),
            }
            for what, share in (("elements", np.full(load.size, 1 / load.size)), ("load", load)):
                for number, meaning in enumerate(states.MEANINGS):
                    name = meaning.replace(" ", "_").replace("-", "_")
                    percent = 100 * share[state == number].sum()
                    known = not np.any(state == states.UNKNOWN)
                    row[f"{what}_in_{name}_percent"] = percent if known else np.nan
            rows.append(row)
    return pd.DataFrame(rows)


#: errors of a peak, and what they are errors of
_PEAK_ERRORS = {
    "peak_frequency_error_percent": "peak_frequency_Hz",
    "peak_amplitude_error_percent": "peak_mm_per_N",
}


def tabulate_accuracy(
    responses: Mapping[tuple[str, str, int], xr.Dataset],
    checks: Mapping[tuple[str, str, int], pd.DataFrame],
) -> pd.DataFrame:
    """Every response of a case against the node-to-node joint in linear modes.

    Parameters
    ----------
    responses
        ``response.nc`` by joint, coordinates and resonance.
    checks
        ``check.csv`` of those that were marched in time.

    Returns
    -------
    DataFrame
        A row for each response and force level. Errors are empty where there is no reference, or
        it or the branch broke off before the window's end; ``reason`` then says why.
        ``energy_error`` and ``residual``, in all linear modes over the force, are the largest of
        all solutions; estimated errors are those of the response file, without any reference;
        ``residual_in_time`` is the largest, and lies at ``worst_in_time_Hz``.
    """
    rows = []
    for (joint, coordinates, resonance), response in responses.items():
        reference = responses.get((*REFERENCE, resonance))
        for level, force in enumerate(response["force_level"].to_numpy()):
            row = _peak(response, level)
            row |= dict.fromkeys((*_PEAK_ERRORS, "curve_error_dB"), np.nan)
            if reference is not None and row["complete"] and _peak(reference, level)["complete"]:
                row |= _peak_errors(response, reference, level)
                curves = _curve(response, level), _curve(reference, level)
                row["curve_error_dB"] = curve_error(*curves)
            mine = (response["excitation_force"] == force) & (response["converged"] == 1)
            for name in ("energy_error", "residual"):
                row[name] = float(abs(response[name].where(mine)).to_series().max())
            row |= _trust(response.isel(force=level))
            where = {"joint": joint, "coordinates": coordinates, "resonance": resonance}
            rows.append({**where, "force_N": force, **row})
    table = pd.DataFrame(rows)
    marched = [
        check[["force_N", "residual_in_time", "frequency_Hz"]]
        .rename(columns={"frequency_Hz": "worst_in_time_Hz"})
        .assign(joint=joint, coordinates=coordinates, resonance=resonance)
        for (joint, coordinates, resonance), check in checks.items()
    ]
    if marched:
        on = ["joint", "coordinates", "resonance", "force_N"]
        table = table.merge(pd.concat(marched), how="left", on=on)
    return table[[name for name in table if name != "reason"] + ["reason"]]


def tabulate_models(
    responses: Mapping[tuple[str, str, str, int], xr.Dataset],
    timings: Mapping[tuple[str, str, str, int], pd.DataFrame],
    converged: tuple[str, str, str, int],
) -> pd.DataFrame:
    """Every response of a case, in any basis, against the converged one, beside what it costs.

    Parameters
    ----------
    responses, timings
        ``response.nc`` and ``timing.csv`` by modal basis, joint, coordinates and resonance.
    converged
        Which of them the others are compared with.

    Returns
    -------
    DataFrame
        A row for each response and force level: errors of its peak, empty where the branch broke
        off, and the median processor time.
    """
    rows = []
    for which, response in responses.items():
        timing = timings[which]
        cost = timing[timing["jacobian"] == "analytic"].groupby("force_N")["cpu_s"].median()
        for level, force in enumerate(response["force_level"].to_numpy()):
            rows.append(
                {
                    **dict(zip(("modes", "joint", "coordinates", "resonance"), which, strict=True)),
                    "force_N": force,
                    "complete": _peak(response, level)["complete"],
                    **_peak_errors(response, responses[converged], level),
                    "cpu_s": cost.get(force, np.nan),
                }
            )
    return pd.DataFrame(rows)


def tabulate_fits(
    fits: Mapping[str, xr.Dataset],
    timings: Mapping[str, pd.DataFrame],
    responses: Mapping[str, xr.Dataset],
) -> pd.DataFrame:
    """What fitted elements cost to find, and how far they are from those they stand for.

    Parameters
    ----------
    fits, timings
        ``joint.nc`` and ``fit_timing.csv`` by the joint's name.
    responses
        ``response.nc`` of these joints and of their regions with all elements, as far as there are.

    Returns
    -------
    DataFrame
        A row for each joint: ``cost_N2`` of eq. 3.3, whether it was minimised or not, summed over
        regions; the largest errors of the loops of any region at any amplitude, in percent of its
        slip force; the largest errors of a peak over all forces, against the same regions with
        all elements, empty where either has none; and the processor time of the fit.
    """
    rows = []
    for name, fit in fits.items():
        worst = dict.fromkeys(_PEAK_ERRORS, np.nan)
        regions = parse_joint(name).regions
        if name in responses and regions in responses:
            for level in range(responses[name].sizes["force"]):
                errors = _peak_errors(responses[name], responses[regions], level)
                worst = {key: np.fmax(worst[key], np.abs(errors[key])) for key in worst}
        rows.append(
            {
                "joint": name,
                "cpu_s": timings[name]["cpu_s"].sum(),
                "cost_N2": float(fit["fit_cost"].sum()),
                "largest_loop_error_percent": 100 * float(fit["largest_loop_error"].max()),
                "rms_loop_error_percent": 100 * float(fit["rms_loop_error"].max()),
                **worst,
            }
        )
    return pd.DataFrame(rows)


def curve_error(
    curve: tuple[NDArray[np.float64], NDArray[np.float64]],
    reference: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> float:
    """Root-mean-square distance of two responses over frequency, in decibels.

    Where a curve is folded, its largest amplitude counts. Both are compared over the frequencies
    they share; 1 dB is a difference of 12 %.

    Parameters
    ----------
    curve, reference
        Frequency and amplitude along the branch, each of shape (solutions,).
    """
    shared = max(curve[0].min(), reference[0].min()), min(curve[0].max(), reference[0].max())
    grid = np.unique(np.concatenate([curve[0], reference[0], shared]))
    grid = grid[(grid >= shared[0]) & (grid <= shared[1])]
    level, reference_level = (
        20 * np.log10(upper_branch(*each, grid)) for each in (curve, reference)
    )
    square = np.trapezoid((level - reference_level) ** 2, grid) / (grid[-1] - grid[0])
    return float(np.sqrt(square))


def upper_branch(
    frequency: NDArray[np.float64], amplitude: NDArray[np.float64], grid: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Largest amplitude of a piecewise-linear branch at each frequency of a grid it covers."""
    before, after = frequency[:-1], frequency[1:]
    covers = (np.minimum(before, after) <= grid[:, None]) & (
        grid[:, None] <= np.maximum(before, after)
    )
    length = np.where(after == before, 1.0, after - before)
    share = (grid[:, None] - before) / length
    value = amplitude[:-1] + share * (amplitude[1:] - amplitude[:-1])
    return np.where(covers, value, -np.inf).max(axis=1)


def tabulate_times(
    timings: Mapping[tuple[str, str, int], pd.DataFrame], published: Published
) -> pd.DataFrame:
    """Median processor times of every response, and their reduction against the reference's.

    Parameters
    ----------
    timings
        ``timing.csv`` by joint, coordinates and resonance.
    published
        The source's tables; they are about the first resonance.

    Returns
    -------
    DataFrame
        A row for each response and force level, with columns for both ways to the Jacobian. A path
        that broke off has no reduction: it did less than the others.
    """
    parts = []
    for (joint, coordinates, resonance), timing in timings.items():
        medians = timing.pivot_table(index="force_N", columns="jacobian", aggfunc="median")
        analytic = medians.xs("analytic", axis=1, level="jacobian").reset_index()
        taken = "forward-difference" in medians.columns.get_level_values("jacobian")
        by_differences = medians["cpu_s"]["forward-difference"] if taken else None
        parts.append(
            pd.DataFrame(
                {
                    "joint": joint,
                    "coordinates": coordinates,
                    "resonance": resonance,
                    "force_N": analytic["force_N"],
                    "cpu_s": analytic["cpu_s"],
                    "cpu_forward_difference_s": by_differences.to_numpy() if taken else np.nan,
                    "solutions": analytic["solutions"].astype(int),
                    "iterations": analytic["iterations"].astype(int),
                    "complete": medians["complete"].min(axis=1).to_numpy() == 1,
                }
            )
        )
    table = pd.concat(parts, ignore_index=True)
    times = ["cpu_s", "cpu_forward_difference_s"]
    on = ["resonance", "force_N"]
    is_reference = (table["joint"] == REFERENCE[0]) & (table["coordinates"] == REFERENCE[1])
    reference = table.loc[is_reference & table["complete"], [*on, *times]]
    joined = table.merge(reference, how="left", on=on, suffixes=("", "_of_reference"))
    for name, column in zip(
        ("reduction_percent", "reduction_forward_difference_percent"), times, strict=True
    ):
        reduction = 100 * (1 - joined[column] / joined[f"{column}_of_reference"])
        table[name] = reduction.where(joined["complete"])
    printed = published.time_reductions().assign(resonance=1)
    on = ["joint", "coordinates", "resonance", "force_N"]
    table = table.merge(printed, how="left", on=on)
    table["difference_points"] = (
        table["reduction_forward_difference_percent"] - table["published_reduction_percent"]
    )
    return table


def _peak(response: xr.Dataset, level: int) -> dict[str, object]:
    at = response.isel(force=level)
    force = float(at["force_level"])
    return {
        "solutions": int((response["excitation_force"] == force).sum()),
        "complete": bool(at["complete"]),
        "peak_frequency_Hz": float(at["peak_frequency"]),
        "peak_mm_per_N": float(at["peak_amplitude"]) * 1e3 / force,
        "reason": str(at["reason"].item()),
    }


def _trust(at: xr.Dataset) -> dict[str, object]:
    """What a response says of itself at a force level: its estimated errors and its folds."""
    return {
        "estimated_peak_error_percent": 100 * float(at["peak_error_estimate"]),
        "estimated_largest_error_percent": 100 * float(at["largest_error_estimate"]),
        "wrong": bool(at["wrong"]),
        "fell_back": bool(at["fell_back"]),
        "turning_points": int(at["turning_points"]),
        "folded_from_Hz": float(at["folded_from"]),
        "folded_to_Hz": float(at["folded_to"]),
    }


def _peak_errors(response: xr.Dataset, reference: xr.Dataset, level: int) -> dict[str, float]:
    """Errors of a peak against the reference's [%], where both paths are complete."""
    found, truth = _peak(response, level), _peak(reference, level)
    whole = found["complete"] and truth["complete"]
    return {
        error: _percent(found[column], truth[column]) if whole else np.nan
        for error, column in _PEAK_ERRORS.items()
    }


def _curve(response: xr.Dataset, level: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    mine = response["excitation_force"].to_numpy() == float(response["force_level"][level])
    return response["frequency"].to_numpy()[mine], response["response_amplitude"].to_numpy()[mine]


def _percent(value: float, reference: float) -> float:
    return 100 * (value / reference - 1)


def _share_of_load(joint: xr.Dataset) -> NDArray[np.float64]:
    """Share of each element in the slip force of the assembled state."""
    slip_force = joints.from_dataset(joint).law.slip_force
    return slip_force / slip_force.sum()


def _in_order_of_slip(
    region: NDArray[np.int64], elements: Mapping[str, NDArray[np.float64]]
) -> pd.DataFrame:
    table = pd.DataFrame({"region": region, **elements})
    table["slips_at"] = table["slip_force_N"] / table["k_kN_per_mm"]
    table = table.sort_values(["region", "slips_at"], kind="stable", ignore_index=True)
    table.insert(1, "element", table.groupby("region").cumcount() + 1)
    return table.drop(columns="slips_at")
