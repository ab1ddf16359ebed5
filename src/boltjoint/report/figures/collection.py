"""Figures of a study, each drawn from its results."""

from collections.abc import Callable
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


def _under_preload(artefact: "Artefact", results: Results, _: dict) -> Figure:
    plot = contact.plot_contact if artefact.kind == "contact" else structure.plot_deformation
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


def _of_table(artefact: "Artefact", results: Results, _: dict) -> Figure:
    plot = {
        "bases": convergence.plot_bases,
        "divisions": convergence.plot_divisions,
        "models": convergence.plot_models,
        "patterns": convergence.plot_patterns,
        "sampling": convergence.plot_sampling,
    }
    return plot[artefact.kind](results.table(artefact.kind, **artefact.which))


def _of_joint(artefact: "Artefact") -> dict[str, object]:
    return {name: artefact.which[name] for name in ("case", "basis", "joint")}


_FIGURES: dict[str, "Callable[[Artefact, Results, dict], Figure]"] = {
    "mesh": _mesh,
    "modes": _modes,
    "contact": _under_preload,
    "deformation": _under_preload,
    "regions": _regions,
    "loops": _loops,
    "response": _response,
    "states": _states,
    "backbone": _backbone,
    "times": _times,
    **dict.fromkeys(["bases", "divisions", "models", "patterns", "sampling"], _of_table),
}
