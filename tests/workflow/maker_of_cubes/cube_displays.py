"""A table of the report in a package of its own."""

from boltjoint.study.display import data_of, table


@table(
    "rows_of_cubes",
    of=lambda contents: [{"case": case} for case in contents.study.cases],
    reads=(data_of("joint", by=["case"]),),
    job="cubes_{case}",
    title="numbers of elements",
)
def rows_of_cubes(artefact, results):
    """Number of friction elements of the joint of the contact pairs."""
    import pandas as pd

    joint = results.dataset("joint", case=artefact.case, basis="free-2", joint="node-to-node")
    return pd.DataFrame({"law": [joint.attrs["law"]], "elements": [joint.sizes["element"]]})
