"""Figures and tables of reduced joints: regions, fitted elements and their loops."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from boltjoint.names import REFERENCE
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import assembly_of_case, data_of, figure, table
from boltjoint.study.response_list import Response

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from boltjoint.report.comparison import Comparison
    from boltjoint.study.stage_inputs import Results

_OF_BASIS = ("case", "basis")


def _divided(contents: Contents) -> Iterator[dict[str, Any]]:
    """Joints of regions that keep all their elements."""
    for case, basis in contents.cases_and_bases():
        for joint in contents.joints(case, basis):
            if joint.division is not None and joint.reduction is None:
                yield {"case": case, "basis": basis, "joint": joint}


def _hyper_reduced(contents: Contents) -> Iterator[dict[str, Any]]:
    """Joints in which few weighted pairs stand for all."""
    for case, basis in contents.cases_and_bases():
        for joint in contents.joints(case, basis):
            if joint.pairs is not None:
                yield {"case": case, "basis": basis, "joint": joint}


def _fitted(contents: Contents) -> Iterator[dict[str, Any]]:
    """Joints whose elements are fitted."""
    for case, basis in contents.cases_and_bases():
        for joint in contents.fitted(case, basis):
            yield {"case": case, "basis": basis, "joint": joint}


def _with_fits(contents: Contents) -> Iterator[dict[str, Any]]:
    for case, basis in contents.cases_and_bases():
        if contents.fitted(case, basis):
            yield {"case": case, "basis": basis}


def _regions_of(contents: Contents, artefact: Artefact) -> list[Artefact]:
    """The joint of the same regions with all their elements."""
    fields = artefact.fields | {"joint": artefact.fields["joint"].regions}
    return contents.select("joint", form="data", **fields)


@figure(
    "regions",
    of=_divided,
    reads=(assembly_of_case, data_of("joint", by=[*_OF_BASIS, "joint"])),
    job="responses_{case}_{basis}",
    section="regions",
    title=lambda artefact: f"{_label(artefact)} on the contact",
    caption="With the number of elements and the share of the normal load of each. Grey pairs have "
    "no element.",
    options=lambda contents, artefact: {"assembly": contents.study.case(artefact.case).assembly},
)
def regions(artefact: Artefact, results: "Results", assembly: str) -> "Figure":
    """The regions of a joint on the contact surface."""
    from boltjoint.report.figures.regions import plot_regions

    mesh = results.dataset("assembly", assembly=assembly)
    return plot_regions(mesh, results.dataset("joint", **artefact.fields))


@figure(
    "weighted_pairs",
    of=_hyper_reduced,
    reads=(assembly_of_case, data_of("joint", by=[*_OF_BASIS, "joint"])),
    job="responses_{case}_{basis}",
    section="pairs",
    title=lambda artefact: f"{artefact.joint.label.capitalize()} on the contact",
    caption="The weight is how many pairs each of them stands for. Grey pairs are left out.",
    options=lambda contents, artefact: {"assembly": contents.study.case(artefact.case).assembly},
)
def weighted_pairs(artefact: Artefact, results: "Results", assembly: str) -> "Figure":
    """The pairs of a hyper-reduced joint on the contact surface."""
    from boltjoint.report.figures.contact import plot_weighted_pairs

    mesh = results.dataset("assembly", assembly=assembly)
    return plot_weighted_pairs(mesh, results.dataset("joint", **artefact.fields))


@figure(
    "loops",
    of=_fitted,
    reads=(data_of("joint", by=[*_OF_BASIS, "joint"]), _regions_of),
    job="responses_{case}_{basis}",
    section="elements",
    title="Hysteresis loops of a region",
    caption=lambda artefact: (
        f"Over one period, at three amplitudes"
        f"{' of the fit' if artefact.joint.reduction == 'elements' else ''}. Where the thin line "
        f"leaves the broad one, the fitted elements do not represent all. Both have "
        "the same stiffness while nothing slips, and the same force in full slip."
    ),
    is_compared=True,
)
def loops(artefact: Artefact, results: "Results", comparison: "Comparison") -> "Figure":
    """Hysteresis loops of a region with fitted elements and with all."""
    from boltjoint.report.figures.contact import plot_loops

    joint = artefact.fields["joint"]
    every = artefact.fields | {"joint": joint.regions}
    return plot_loops(
        results.dataset("joint", **artefact.fields),
        results.dataset("joint", **every),
        comparison.region_of_loops(joint),
    )


@table(
    "regions",
    of=_divided,
    reads=(data_of("joint", by=[*_OF_BASIS, "joint"]),),
    job="basis_{case}_{basis}",
    section="regions",
    title="{joint} in {basis}",
)
def elements_of_regions(artefact: Artefact, results: "Results") -> "pd.DataFrame":
    """Elements, load and stiffness of the regions of a joint."""
    from boltjoint.study.tables.joints import tabulate_regions

    return tabulate_regions(results.dataset("joint", **artefact.fields))


@table(
    "elements",
    of=_fitted,
    reads=(data_of("joint", by=[*_OF_BASIS, "joint"]),),
    job="basis_{case}_{basis}",
    section="elements",
    title="elements of {joint} in {basis}",
    is_compared=True,
)
def elements(artefact: Artefact, results: "Results", comparison: "Comparison") -> "pd.DataFrame":
    """Fitted elements of a reduced joint."""
    from boltjoint.study.tables.joints import tabulate_elements

    table = tabulate_elements(results.dataset("joint", **artefact.fields))
    return comparison.beside(artefact, table)


@table(
    "fits",
    of=_with_fits,
    reads=(data_of("joint", "fit_timing", "response", by=_OF_BASIS),),
    job="basis_{case}_{basis}",
    section="fits",
    title="fits of elements in {basis}",
    options=lambda contents, artefact: {
        "responses": contents.responses(artefact.case, artefact.basis)
    },
)
def fits(artefact: Artefact, results: "Results", responses: list[Response]) -> "pd.DataFrame":
    """Cost and errors of fitted elements."""
    from boltjoint.study.tables.joints import tabulate_fits

    fields = artefact.fields
    linear = [response for response in responses if response[2:] == (REFERENCE[1], 1)]
    joints = dict.fromkeys(response.joint for response in responses)
    fitted = [joint for joint in joints if joint.is_fitted]
    return tabulate_fits(
        {joint: results.dataset("joint", **fields, joint=joint) for joint in fitted},
        {joint: results.data("fit_timing", **fields, joint=joint) for joint in fitted},
        {
            response.joint: results.dataset("response", case=artefact.case, **response._asdict())
            for response in linear
        },
    )


def _label(artefact: Artefact) -> str:
    words = artefact.fields["joint"].regions.label
    return words[:1].upper() + words[1:]
