"""Tables of convergence: errors of forces, bases and regions."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from boltjoint.names import REFERENCE, Basis
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import data_of, table
from boltjoint.study.response_list import Response

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from boltjoint.study.stage_inputs import Results


def solved_in_linear_modes(contents: Contents) -> list[dict[str, Any]]:
    """One, if the node-to-node joint of any case is solved in linear modes."""
    return [{}] if _references(contents) else []


def compared_assemblies(contents: Contents) -> list[dict[str, Any]]:
    """The assemblies in whose resonances bases are compared."""
    return [{"assembly": name} for name in contents.compared_assemblies()]


def cases_in_several_bases(contents: Contents) -> list[dict[str, Any]]:
    """The cases whose peaks are found in several bases."""
    return [{"case": case} for case in contents.study.cases if contents.study.convergence.bases]


def divided_cases(contents: Contents) -> Iterator[dict[str, Any]]:
    """The cases whose contact is divided into several numbers of regions."""
    for case in contents.study.cases:
        converged = contents.converged(case)
        if converged and contents.study.convergence.regions:
            yield {"case": case, "basis": converged.basis}


def _references(contents: Contents) -> dict[str, Response]:
    """By case with a closed form, the first response of the node-to-node joint in linear modes."""
    references = {
        name: contents.references(name)
        for name, case in contents.study.cases.items()
        if case.contact.declaration.has_closed_form
    }
    return {case: responses[0] for case, responses in references.items() if responses}


def _joints_and_responses(contents: Contents, _: Artefact) -> Iterator[Artefact]:
    for case, reference in _references(contents).items():
        yield from contents.select("joint", case=case, basis=reference.basis, joint=reference.joint)
        yield from contents.select("response", form="data", case=case, **reference._asdict())


@table(
    "sampling",
    of=solved_in_linear_modes,
    reads=(_joints_and_responses,),
    job="sampling",
    page="accuracy",
    section="sampling",
    title="forces by AFT against the closed form",
    options=lambda contents, _: {"references": _references(contents)},
)
def sampling(_: Artefact, results: "Results", references: Mapping[str, Response]) -> "pd.DataFrame":
    """Errors of forces by AFT."""
    from boltjoint.joint.io import joint_from_dataset
    from boltjoint.study.convergence import tabulate_sampling

    solved = {}
    for case, reference in references.items():
        joint = results.dataset("joint", case=case, basis=reference.basis, joint=reference.joint)
        response = results.dataset("response", case=case, **reference._asdict())
        solved[case] = joint_from_dataset(joint), response
    return tabulate_sampling(solved)


@table(
    "patterns",
    of=compared_assemblies,
    reads=(
        lambda contents, artefact: [
            data
            for basis in contents.study.convergence.bases
            for data in contents.select(
                "modes", form="data", assembly=artefact.assembly, basis=basis
            )
        ],
        data_of("patterns", by=["assembly"]),
    ),
    job="patterns_{assembly}",
    page="accuracy",
    section="patterns",
    title="resonances of {assembly} while parts of the contact stick",
    options=lambda contents, _: {"bases": contents.study.convergence.bases},
)
def patterns(artefact: Artefact, results: "Results", bases: Sequence[Basis]) -> "pd.DataFrame":
    """Errors of resonances by basis."""
    from boltjoint.study.convergence import tabulate_patterns

    modes: dict[str, xr.Dataset] = {
        basis: results.dataset("modes", **artefact.fields, basis=basis) for basis in bases
    }
    return tabulate_patterns(modes, results.dataset("patterns", **artefact.fields))


@table(
    "bases",
    of=cases_in_several_bases,
    reads=(
        lambda contents, artefact: [
            data
            for basis in contents.study.convergence.bases
            for data in contents.select("peaks", case=artefact.case, basis=basis)
        ],
    ),
    job="bases_{case}",
    page="accuracy",
    section="bases",
    title="peaks by basis",
    options=lambda contents, _: {"bases": contents.study.convergence.bases},
)
def bases(artefact: Artefact, results: "Results", bases: Sequence[Basis]) -> "pd.DataFrame":
    """Errors of peaks by basis."""
    from boltjoint.study.convergence import tabulate_basis_peaks

    fields = artefact.fields | {"joint": REFERENCE[0]}
    return tabulate_basis_peaks(
        {compared: results.data("peaks", **fields, basis=compared) for compared in bases}
    )


@table(
    "divisions",
    of=divided_cases,
    reads=(
        lambda contents, artefact: [
            data
            for kind in ("joint", "peaks")
            for data in contents.select(kind, **artefact.fields, joint=REFERENCE[0])
        ],
        lambda contents, artefact: contents.select("preload", **_preload_of(contents, artefact)),
    ),
    job="divisions_{case}_{basis}",
    page="accuracy",
    section="divisions",
    title="regions, by division and number",
    options=lambda contents, artefact: {
        "preload": _preload_of(contents, artefact),
        "steps": contents.study.solver.steps,
        "counts": contents.study.convergence.regions,
        "damping": contents.study.case(artefact.case).structural_damping,
        "division": contents.study.case(artefact.case).regions.division,
    },
)
def divisions(
    artefact: Artefact,
    results: "Results",
    preload: Mapping[str, Any],
    steps: Mapping[str, Any],
    **options: Any,  # noqa: ANN401
) -> "pd.DataFrame":
    """Errors of peaks by division and number of regions."""
    from boltjoint.joint.io import joint_from_dataset
    from boltjoint.solvers.step_control import StepControl
    from boltjoint.study.convergence import tabulate_divisions

    fields = artefact.fields | {"joint": REFERENCE[0]}
    return tabulate_divisions(
        joint_from_dataset(results.dataset("joint", **fields)),
        results.dataset("preload", **preload),
        reference=results.data("peaks", **fields),
        control=StepControl(**steps),
        **options,
    )


def reduced_cases(contents: Contents) -> Iterator[dict[str, Any]]:
    """The cases whose contact is reduced in several ways."""
    for case in contents.study.cases:
        if (converged := contents.converged(case)) and contents.reduced(case):
            yield {"case": case, "basis": converged.basis}


def any_reduced(contents: Contents) -> list[dict[str, Any]]:
    """One, if the contact of any case is reduced in several ways."""
    return [{}] if any(reduced_cases(contents)) else []


def _reduced_joints(contents: Contents, artefact: Artefact) -> list[Artefact]:
    names = [REFERENCE[0], *contents.reduced(artefact.fields["case"])]
    return [contents.select("joint", **artefact.fields, joint=name)[0] for name in names]


@table(
    "reductions",
    of=reduced_cases,
    reads=(_reduced_joints,),
    job="reductions_{case}_{basis}",
    page="accuracy",
    section="reductions",
    title="reductions of the contact",
    options=lambda contents, artefact: {
        "joints": [REFERENCE[0], *contents.reduced(artefact.case)],
        "forces": contents.study.case(artefact.case).levels,
        "damping": contents.study.case(artefact.case).structural_damping,
        "steps": contents.study.solver.steps,
    },
)
def reductions(
    artefact: Artefact,
    results: "Results",
    joints: Sequence[str],
    steps: Mapping[str, Any],
    **options: Any,  # noqa: ANN401
) -> "pd.DataFrame":
    """Errors and times of reduced joints."""
    from boltjoint.joint.io import joint_from_dataset
    from boltjoint.solvers.step_control import StepControl
    from boltjoint.study.convergence import tabulate_reductions

    loaded = {
        name: joint_from_dataset(results.dataset("joint", **artefact.fields, joint=name))
        for name in joints
    }
    return tabulate_reductions(loaded, control=StepControl(**steps), **options)


def _preload_of(contents: Contents, artefact: Artefact) -> dict[str, Any]:
    case = contents.study.case(artefact.fields["case"])
    return {"assembly": case.assembly, "preload_N": case.preload}
