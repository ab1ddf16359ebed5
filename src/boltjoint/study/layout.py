"""Where does each result of a study lie? Folders are named by what was varied.

A file sits in the folder of what it depends on, so that a new force never touches the preload and
a new stiffness never touches the mesh.
"""

from collections.abc import Iterator

from boltjoint.config.study import Study
from boltjoint.names import (
    PAGES,
    REFERENCE,
    is_enriched,
    parse_coordinates,
    parse_joint,
    parse_modes,
)


def assembly(name: str) -> str:
    """Mesh of an assembly."""
    return f"results/assemblies/{name}/assembly.nc"


def modes(name: str, family: str) -> str:
    """Linear modes of an assembly."""
    return f"results/assemblies/{name}/{family}/modes.nc"


def principal(name: str) -> str:
    """What the motions of an assembly have in common, of which its enriched bases are made."""
    return f"results/assemblies/{name}/principal.nc"


def patterns(name: str) -> str:
    """Resonances of the full model of an assembly while parts of its contact stick."""
    return f"results/assemblies/{name}/patterns.nc"


def preload(name: str, newton: float) -> str:
    """Contact of an assembly under a preload per bolt [N]."""
    return f"results/assemblies/{name}/preload={newton:.15g}/preload.nc"


def joint(case: str, family: str, name: str) -> str:
    """A joint in the modes of its assembly."""
    return f"results/cases/{case}/{family}/{name}/joint.nc"


def peaks(case: str, family: str, name: str) -> str:
    """Peaks of a joint around the first resonance, without the rest of its responses."""
    return f"results/cases/{case}/{family}/{name}/peaks.csv"


def fit_timing(case: str, family: str, name: str) -> str:
    """How long the elements of a joint took to fit."""
    return f"results/cases/{case}/{family}/{name}/fit_timing.csv"


def response(case: str, family: str, name: str, coordinates: str, resonance: int) -> str:
    """Frequency responses of a joint around a resonance."""
    return f"results/cases/{case}/{family}/{name}/{coordinates}/resonance={resonance}/response.nc"


def timing(case: str, family: str, name: str, coordinates: str, resonance: int) -> str:
    """How long those responses took."""
    return response(case, family, name, coordinates, resonance).replace("response.nc", "timing.csv")


def backbone(case: str, family: str, name: str, resonance: int) -> str:
    """Natural frequency and damping of a joint over its amplitude."""
    return response(case, family, name, "backbone", resonance).replace("response.nc", "backbone.nc")


def backbones(study: Study, case: str, family: str, resonance: int) -> list[str]:
    """The joints of a case whose response is rebuilt from the backbone of a resonance."""
    return [
        name
        for basis, name, coordinates, at in solved(study, case)
        if (basis, coordinates, at) == (family, "backbone", resonance)
    ]


def check(case: str, family: str, name: str, coordinates: str, resonance: int) -> str:
    """Whether those responses hold when they are marched in time."""
    return response(case, family, name, coordinates, resonance).replace("response.nc", "check.csv")


def preload_of_case(study: Study, case: str) -> str:
    """Contact of the assembly of a case under the preload of that case."""
    return preload(study.case(case).assembly, study.case(case).preload_N)


def modes_of_case(study: Study, case: str, family: str) -> str:
    """Linear modes of the assembly of a case."""
    return modes(study.case(case).assembly, family)


def solved(study: Study, case: str) -> Iterator[tuple[str, str, str, int]]:
    """All responses of a case: modes, joint, coordinates and resonance of each."""
    yield from study.case(case).solved()


def references(study: Study) -> dict[str, tuple[str, str, str, int]]:
    """By case, the first of its responses of the node-to-node joint in linear modes, if any."""
    found = {}
    for case in study.cases:
        for which in _node_to_node(study, case):
            found.setdefault(case, which)
    return found


def _node_to_node(study: Study, case: str) -> list[tuple[str, str, str, int]]:
    """The responses of the node-to-node joint of a case in linear modes."""
    return [which for which in solved(study, case) if which[1:3] == REFERENCE]


def marched(study: Study) -> dict[str, tuple[str, str, str, int]]:
    """By case with forces to march at, its first response of modes without contact, if any.

    Vectors of enriched bases stick at frequencies that no march can step through.
    """
    found = {}
    for case in study.cases:
        for which in _node_to_node(study, case):
            if study.case(case).verification_forces_N and not is_enriched(which[0]):
                found.setdefault(case, which)
    return found


def balanced(study: Study, case: str) -> dict[str, tuple[str, str, str, int]]:
    """By basis, the response of a case with forces to march at whose further harmonics are solved.

    That of the node-to-node joint in linear modes, around the lowest resonance.
    """
    found = {}
    if study.case(case).verification_forces_N:
        for which in sorted(_node_to_node(study, case), key=lambda each: each[3]):
            found.setdefault(which[0], which)
    return found


def converged(study: Study) -> dict[str, tuple[str, str, str, int]]:
    """By case, the response that comes closest to the structure, if any.

    That of the node-to-node joint in linear modes, around the first resonance, in the largest basis
    that holds the contact.
    """
    found = {}
    for case in study.cases:
        bases = [
            which[0]
            for which in solved(study, case)
            if which[1:] == (*REFERENCE, 1) and is_enriched(which[0])
        ]
        if bases:
            found[case] = (max(bases, key=parse_modes), *REFERENCE, 1)
    return found


def fitted(study: Study, case: str, family: str) -> list[str]:
    """The joints of a case and basis whose elements are fitted."""
    joints = study.case(case).joints(family)
    return [name for name in joints if parse_joint(name).elements is not None]


def compared_assemblies(study: Study) -> list[str]:
    """The assemblies in whose resonances bases are compared: those that cases use, if any are."""
    used = [case.assembly for case in study.cases.values()]
    return list(dict.fromkeys(used)) if study.convergence.bases else []


def compared(study: Study, case: str) -> list[tuple[str, str, str, int]]:
    """The responses of a case that are around the same resonance as its converged one."""
    return [which for which in solved(study, case) if which[3] == converged(study)[case][3]]


def is_checked(study: Study, coordinates: str) -> bool:
    """Whether a march in time checks such responses: all equations solved, with exact forces."""
    return parse_coordinates(coordinates).kind == "linear" and study.solver.sampling is None


def jacobians(family: str, joint_name: str, coordinates: str) -> list[str]:
    """Ways to the Jacobian that are timed: forward differences too for what the source solves."""
    parsed = parse_joint(joint_name)
    in_source = (
        not is_enriched(family)
        and parsed.division in (None, "regions")
        and parsed.reduction in (None, "elements")
        and parse_coordinates(coordinates).kind in ("linear", "real")
    )
    return ["analytic", *(["forward-difference"] if in_source else [])]


def flat(joint_name: str) -> str:
    """A joint's name without folders, for names of tables and figures."""
    return joint_name.replace("/", "_")


def unflat(name: str) -> str:
    """The joint's name from its flat form."""
    return name.replace("_", "/")


def preloads(study: Study) -> list[tuple[str, float]]:
    """Every assembly with every preload per bolt [N] that it is tightened to.

    An assembly that no case uses is tightened to its own preload.
    """
    used = [(case.assembly, case.preload_N) for case in study.cases.values()]
    nominal = [
        (name, found.preload_N)
        for name, found in study.assemblies.items()
        if found.preload_N is not None and all(name != assembly for assembly, _ in used)
    ]
    return list(dict.fromkeys(used + nominal))


def families(study: Study) -> list[str]:
    """Every modal basis that a case uses."""
    return list(dict.fromkeys(family for case in study.cases.values() for family in case.bases))


def contact_of_basis(study: Study, name: str) -> str:
    """The contact of an assembly by which a basis is enriched: its first one, for all are alike."""
    return preload(*next(which for which in preloads(study) if which[0] == name))


def targets(study: Study) -> list[str]:
    """Everything a study makes, so that whatever is lost is made again."""
    return list(dict.fromkeys([*_data(study), *_shown(study), *pages(study)]))


def _data(study: Study) -> list[str]:
    found = ["results/environment.json"]
    compared_in = study.convergence.bases
    compared_of = compared_assemblies(study)
    for name in study.assemblies:
        found += [assembly(name), f"results/assemblies/{name}/mesh.vtu"]
        bases = [*families(study), *(compared_in if name in compared_of else ())]
        for family in bases:
            found += _with_view(modes(name, family))
        if any(map(is_enriched, bases)):
            found.append(principal(name))
        if name in compared_of:
            found.append(patterns(name))
    for which in preloads(study):
        found += _with_view(preload(*which))
    for case in study.cases:
        found += _data_of_case(study, case)
    return found


def _data_of_case(study: Study, case: str) -> Iterator[str]:
    compared_in = list(study.convergence.bases)
    if study.convergence.regions and case in converged(study):
        compared_in.append(converged(study)[case][0])
    for family in compared_in:
        yield peaks(case, family, REFERENCE[0])
    for family in dict.fromkeys([*study.case(case).bases, *compared_in]):
        yield joint(case, family, REFERENCE[0])
    for family in study.case(case).bases:
        for name in study.case(case).joints(family):
            yield joint(case, family, name)
            if parse_joint(name).division is not None:
                yield joint(case, family, parse_joint(name).regions)
        for name in fitted(study, case, family):
            yield fit_timing(case, family, name)
    for which in solved(study, case):
        family, name, coordinates, resonance = which
        yield from (response(case, *which), timing(case, *which))
        if is_checked(study, coordinates):
            yield check(case, *which)
        if coordinates == "backbone":
            yield backbone(case, family, name, resonance)


def _with_view(path: str) -> list[str]:
    return [path, path.removesuffix(".nc") + ".vtu"]


def _shown(study: Study) -> list[str]:
    found = _table("contact")
    if references(study):
        found += _table_and_figure("sampling")
    for case, (family, *_) in converged(study).items():
        found += _table_and_figure(f"models_{case}")
        if study.convergence.regions:
            found += _table_and_figure(f"divisions_{case}_{family}")
    for name in compared_assemblies(study):
        found += _table_and_figure(f"patterns_{name}")
    if study.convergence.bases:
        for case in study.cases:
            found += _table_and_figure(f"bases_{case}")
    # vectors of enriched bases are no modes of the structure
    for family in (each for each in families(study) if not is_enriched(each)):
        found += _table(f"natural_frequencies_{family}")
        found += [f"results/figures/modes_{name}_{family}.svg" for name in study.assemblies]
    found += [f"results/figures/mesh_{name}.svg" for name in study.assemblies]
    for name, newton in preloads(study):
        where = f"{name}_preload={newton:.15g}"
        found += [f"results/figures/{what}_{where}.svg" for what in ("contact", "deformation")]
    for case_name, case in study.cases.items():
        for family in case.bases:
            where = f"{case_name}_{family}"
            for what in ("accuracy", "states", "times"):
                found += _table(f"{what}_{where}")
            found += [
                f"results/figures/times_{where}_resonance={resonance}.svg"
                for resonance in case.resonances(family)
            ]
            found += [
                f"results/figures/backbone_{where}_resonance={resonance}.svg"
                for resonance in case.resonances(family)
                if backbones(study, case_name, family, resonance)
            ]
            if fitted(study, case_name, family):
                found += _table(f"fits_{where}")
            for joint_name in case.joints(family):
                parsed = parse_joint(joint_name)
                if parsed.elements is not None:
                    found += _table(f"elements_{where}_{flat(joint_name)}")
                    found.append(f"results/figures/loops_{where}_{flat(joint_name)}.svg")
                if parsed.division is not None:
                    found += _table(f"regions_{where}_{parsed.regions}")
                    found.append(f"results/figures/regions_{where}_{parsed.regions}.svg")
        if case_name in marched(study):
            found += _table(f"harmonics_{case_name}_{marched(study)[case_name][0]}")
        for family in balanced(study, case_name):
            found += _table(f"harmonic_peaks_{case_name}_{family}")
        for family, joint_name, coordinates, resonance in solved(study, case_name):
            where = f"{case_name}_{family}_{flat(joint_name)}_{coordinates}_resonance={resonance}"
            found.append(f"results/figures/response_{where}.svg")
            if joint_name == REFERENCE[0] and parse_coordinates(coordinates).kind != "backbone":
                found.append(f"results/figures/states_{where}.svg")
    return found


def _table(name: str) -> list[str]:
    return [f"results/tables/{name}.csv", f"results/tables/{name}.html"]


def _table_and_figure(name: str) -> list[str]:
    return [*_table(name), f"results/figures/{name}.svg"]


def page(name: str) -> str:
    """A page of the report."""
    return f"results/report/{name}.html"


def packed(name: str) -> str:
    """The same page as the report of the workflow embeds it."""
    return f"results/report/packed/{name}.html"


def pages(study: Study) -> list[str]:
    """The pages of the report: overview, accuracy, structure, and one for each case."""
    every = [*PAGES, *study.cases]
    return [*map(page, every), *map(packed, every)]
