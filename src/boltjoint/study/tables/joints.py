"""Tables of regions, fitted elements and contact states."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from boltjoint.friction import contact_states
from boltjoint.joint.io import joint_from_dataset
from boltjoint.names import JointName
from boltjoint.study.tables.accuracy import PEAK_ERRORS, peak_errors


def tabulate_regions(joint: xr.Dataset) -> pd.DataFrame:
    """Elements, load and stiffness of each region of a joint, from its ``joint.nc``.

    Where the normal load varies, open pairs have elements as well. Stiffnesses are those of the
    elements that carry load in the assembled state, which alone act in small motion.
    """
    law = joint_from_dataset(joint).contact.element_law
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
        columns["normal"] = law.stiffness_along("normal") * loaded / 1e6
        sums["normal_stiffness_kN_per_mm"] = ("normal", "sum")
    table = pd.DataFrame(columns).groupby("region").agg(elements=("x", "size"), **sums)
    table["share_of_load_percent"] = 100 * table["slip_force_N"] / slip_force.sum()
    return table.reset_index()


def tabulate_elements(joint: xr.Dataset) -> pd.DataFrame:
    """Fitted elements of a reduced joint, in the order they slip.

    The slip force is that of the assembled state: mu times the normal load that the element then
    has. Where that load varies, normal stiffnesses are listed too.

    Parameters
    ----------
    joint
        ``joint.nc`` of a reduced joint.
    """
    law = joint_from_dataset(joint).contact.element_law
    columns = {"k_kN_per_mm": law.tangential_stiffness / 1e6, "slip_force_N": law.slip_force}
    if "normal" in law.directions:
        columns["normal_k_kN_per_mm"] = law.stiffness_along("normal") / 1e6
    columns |= {name: law.quantity(name) for name in law.declaration.shape_parameters}
    return in_order_of_slip(law.point_of_element + 1, columns)


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
        states = response["contact_state"].transpose("force", "element").to_numpy()
        load = of_load[joint]
        if load.size != states.shape[1]:
            raise ValueError(
                f"the response of {joint} has {states.shape[1]} elements, the joint {load.size}"
            )
        for level, state in enumerate(states):
            row = {
                "joint": joint,
                "coordinates": coordinates,
                "resonance": resonance,
                "force_N": float(response["force_level"][level]),
                "peak_frequency_Hz": float(response["peak_frequency"][level]),
            }
            for what, share in (("elements", np.full(load.size, 1 / load.size)), ("load", load)):
                for number, meaning in enumerate(contact_states.MEANINGS):
                    name = meaning.replace(" ", "_").replace("-", "_")
                    percent = 100 * share[state == number].sum()
                    is_complete = not np.any(state == contact_states.UNKNOWN)
                    row[f"{what}_in_{name}_percent"] = percent if is_complete else np.nan
            rows.append(row)
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
        worst = dict.fromkeys(PEAK_ERRORS, np.nan)
        regions = JointName(name).regions
        if name in responses and regions in responses:
            for level in range(responses[name].sizes["force"]):
                errors = peak_errors(responses[name], responses[regions], level)
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


def _share_of_load(joint: xr.Dataset) -> NDArray[np.float64]:
    """Share of each element in the slip force of the assembled state."""
    slip_force = joint_from_dataset(joint).law.slip_force
    return slip_force / slip_force.sum()


def in_order_of_slip(
    region: NDArray[np.int64], elements: Mapping[str, NDArray[np.float64]]
) -> pd.DataFrame:
    """Elements of every region by the displacement at which they slip, numbered from 1.

    Parameters
    ----------
    region
        Number of the region of each element.
    elements
        ``k_kN_per_mm``, ``slip_force_N`` and further columns.
    """
    table = pd.DataFrame({"region": region, **elements})
    table["slips_at"] = table["slip_force_N"] / table["k_kN_per_mm"]
    table = table.sort_values(["region", "slips_at"], kind="stable", ignore_index=True)
    table.insert(1, "element", table.groupby("region").cumcount() + 1)
    return table.drop(columns="slips_at")
