"""Figures of a study, each drawn from its results."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from boltjoint.names import REFERENCE
from boltjoint.report.figures import contact, convergence, responses, structure, times
from boltjoint.study.results import Results

if TYPE_CHECKING:
    from boltjoint.study.artefact_list import Artefact


def draw(artefact: "Artefact", results: Results, **options: object) -> Figure:
    """A figure of a study.

    Parameters
    ----------
    artefact
        The figure; the keys of its kind are those of ``_FIGURES``.
    results
        The data that it is drawn from.
    options
        Further data: ``assembly`` of the case, ``regions`` whose loops are drawn, by joint,
        ``joints`` with backbones by resonance, ``forces`` [N].
    """
    return _FIGURES[artefact.kind](artefact, results, options)


def _modes(artefact: "Artefact", results: Results, _: dict) -> Figure:
    return structure.plot_modes(
        results.dataset("assembly", assembly=artefact.assembly),
        results.dataset("modes", **artefact.which),
    )


def _mesh(artefact: "Artefact", results: Results, _: dict) -> Figure:
    return structure.plot_mesh(results.dataset("assembly", **artefact.which))


def _under_preload(
    plot: Callable[..., Figure], artefact: "Artefact", results: Results, _: dict
) -> Figure:
    return plot(
        results.dataset("assembly", assembly=artefact.assembly),
        results.dataset("preload", **artefact.which),
    )


def _regions(artefact: "Artefact", results: Results, options: dict) -> Figure:
    return contact.plot_regions(
        results.dataset("assembly", assembly=options["assembly"]),
        results.dataset("joint", **artefact.which),
    )


def _states(artefact: "Artefact", results: Results, options: dict) -> Figure:
    return contact.plot_states(
        results.dataset("assembly", assembly=options["assembly"]),
        results.dataset("joint", **_of_joint(artefact)),
        results.dataset("response", **artefact.which),
    )


def _loops(artefact: "Artefact", results: Results, options: dict) -> Figure:
    return contact.plot_loops(
        results.dataset("joint", **artefact.which),
        results.dataset("joint", **_of_joint(artefact) | {"joint": artefact.joint.regions}),
        options["regions"][artefact.joint],
    )


def _response(artefact: "Artefact", results: Results, _: dict) -> Figure:
    joint, coordinates = REFERENCE
    reference = artefact.which | {"joint": joint, "coordinates": coordinates}
    has_reference = reference != artefact.which and results.has("response", **reference)
    return responses.plot_response(
        results.dataset("response", **artefact.which),
        artefact.joint,
        artefact.coordinates,
        reference=results.dataset("response", **reference) if has_reference else None,
    )


def _backbone(artefact: "Artefact", results: Results, options: dict) -> Figure:
    return responses.plot_backbones(
        {
            joint: results.dataset("backbone", **artefact.which, joint=joint)
            for joint in options["joints"][artefact.resonance]
        },
        options["forces"],
    )


def _times(artefact: "Artefact", results: Results, _: dict) -> Figure:
    table = results.table("times", case=artefact.case, basis=artefact.basis)
    return times.plot_times(table, artefact.resonance)


def _of_table(
    plot: Callable[..., Figure], artefact: "Artefact", results: Results, _: dict
) -> Figure:
    return plot(results.table(artefact.kind, **artefact.which))


def _of_joint(artefact: "Artefact") -> dict[str, object]:
    return {name: artefact.which[name] for name in ("case", "basis", "joint")}


_FIGURES: dict[str, "Callable[[Artefact, Results, dict], Figure]"] = {
    "mesh": _mesh,
    "modes": _modes,
    "contact": partial(_under_preload, contact.plot_contact),
    "deformation": partial(_under_preload, structure.plot_deformation),
    "regions": _regions,
    "loops": _loops,
    "response": _response,
    "states": _states,
    "backbone": _backbone,
    "times": _times,
    "bases": partial(_of_table, convergence.plot_bases),
    "divisions": partial(_of_table, convergence.plot_divisions),
    "models": partial(_of_table, convergence.plot_models),
    "patterns": partial(_of_table, convergence.plot_patterns),
    "sampling": partial(_of_table, convergence.plot_sampling),
}
