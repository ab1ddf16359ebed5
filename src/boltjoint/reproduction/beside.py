"""Tables of a study with the published values beside its own."""

import pandas as pd

from boltjoint.reproduction.published import Published

#: columns beside those called ``published_...`` that hold or compare published values
_COMPARISONS = ("source_table", "k_ratio", "slip_force_ratio", "difference_points")


def frequencies(table: pd.DataFrame, published: Published) -> pd.DataFrame:
    """Natural frequencies beside the published ones, by assembly and bending mode.

    Parameters
    ----------
    table
        As ``tabulate_frequencies`` returns it.
    published
        The published tables; without any there are no columns for them.
    """
    if published.is_empty:
        return table
    printed = published.natural_frequencies().rename(columns={"frequency_Hz": "published_Hz"})
    table = table.merge(printed, how="left", on=["assembly", "bending_mode"])
    table["difference_percent"] = 100 * (table["frequency_Hz"] / table["published_Hz"] - 1)
    return table


def contact(table: pd.DataFrame, published: Published) -> pd.DataFrame:
    """Numbers of pairs and of loaded pairs beside those of published friction elements.

    Parameters
    ----------
    table
        As ``tabulate_contact`` returns it.
    published
        The published tables; without any there are no columns for them.
    """
    if published.is_empty:
        return table
    printed = published.contact_nodes().set_index(["assembly", "contact_law"])["contact_nodes"]
    table = table.copy()
    for law, column in (("variable", "pairs"), ("constant", "loaded_pairs")):
        numbers = [printed.get((assembly, law)) for assembly in table["assembly"]]
        table.insert(int(table.columns.get_loc(column)) + 1, f"published_{column}", numbers)
    return table


def elements(table: pd.DataFrame, joint: str, published: Published) -> pd.DataFrame:
    """Fitted elements beside the published ones, both in the order in which they slip.

    The source takes normal stiffnesses equal to the tangential ones.

    Parameters
    ----------
    table
        As ``tabulate_elements`` returns it.
    joint
        Name of the joint, ``regions=N/elements=M``.
    published
        The published tables.
    """
    printed = published.parameters(joint)
    if printed.empty:
        return table
    # imported here: other tables need no joints
    from boltjoint.study.tables.joints import in_order_of_slip

    theirs = in_order_of_slip(
        printed["joint"].to_numpy(),
        {"k_kN_per_mm": printed["k_kN_per_mm"], "slip_force_N": printed["mu_n_N"]},
    ).rename(columns={name: f"published_{name}" for name in ("k_kN_per_mm", "slip_force_N")})
    table = table.merge(theirs, how="left", on=["region", "element"])
    table["k_ratio"] = table["k_kN_per_mm"] / table["published_k_kN_per_mm"]
    table["slip_force_ratio"] = table["slip_force_N"] / table["published_slip_force_N"]
    return table.assign(source_table=printed["source_table"].iloc[0])


def times(table: pd.DataFrame, published: Published) -> pd.DataFrame:
    """Solution times beside the published ones, which are about the first resonance.

    Parameters
    ----------
    table
        As ``tabulate_times`` returns it.
    published
        The published tables; without a case study there are no columns for them.
    """
    if published.case is None:
        return table
    printed = published.time_reductions().assign(resonance=1)
    on = ["joint", "coordinates", "resonance", "force_N"]
    table = table.merge(printed, how="left", on=on)
    table["difference_points"] = (
        table["reduction_forward_difference_percent"] - table["published_reduction_percent"]
    )
    return table


def without_published(table: pd.DataFrame) -> pd.DataFrame:
    """A table without columns of published values and of comparisons with them."""
    published = [column for column in table if column.startswith("published_")]
    return table.drop(columns=[*published, *_COMPARISONS], errors="ignore")
