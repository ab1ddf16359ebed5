"""What does not go together in a study: cases, assemblies and settings."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

from boltjoint.config.case import Case
from boltjoint.config.described import Described
from boltjoint.config.error_messages import choice
from boltjoint.config.numerical_options import ContactAdaptedBasis, Settings
from boltjoint.config.types import CONFIG_FILE, KeyPath, Problems
from boltjoint.config.varied_case import SolvedCase
from boltjoint.names import Basis, Preload


def conflicts_of_case(
    case: Case,
    assembly: Described | None,
    settings: Settings | None,
    published: Collection[str] | None,
) -> Problems:
    """What the assembly, the settings and the source do not allow in a case."""
    if assembly is not None:
        yield from _conflicts_of_joints(case, assembly)
        yield from conflicts_of_preload(case, assembly)
        yield from conflicts_of_surfaces(case, assembly)
        yield from conflicts_of_places(case, assembly)
    if settings is not None:
        yield from _conflicts_of_options(case, settings)
        yield from _conflicts_of_bases(case, assembly, settings.contact_adapted_basis)
    if published is not None and case.published is not None and case.published not in published:
        yield (
            ("published",),
            f"is no case study of the source{choice(case.published, published)}",
        )


def tightened(
    content: Mapping[str, Any], case: Case, assembly: Described
) -> tuple[dict[str, Any], list[tuple[KeyPath, str]]]:
    """The content of a case with the preload that bolts have by name, or by their assembly.

    Parameters
    ----------
    content, case
        What the file says, and what it was read as.
    assembly
        Its assembly.

    Returns
    -------
    dict, list
        The content, where ``preload_N`` and ``preload_ratios`` tell all; and what is wrong.
    """
    named, names = case.bolt_preloads_N or {}, assembly.bolt_names
    problems: list[tuple[KeyPath, str]] = [
        (("bolt_preloads_N", name), f"is no bolt of {case.assembly}{choice(name, names)}")
        for name in named
        if name not in names
    ]
    own = assembly.own_preload if case.preload_N is None else Preload.of(case.preload_N)
    missing = [name for name in names if name not in named]
    if own is None and (missing or not names):
        sentence = f"is missing: {case.assembly} gives its bolts none"
        if named:
            sentence += f", nor does bolt_preloads_N tell that of {missing[0]}"
        problems.append((("preload_N",), sentence))
    if problems:
        return {}, problems
    of_all = 0.0 if own is None else own.of_bolts
    if not isinstance(of_all, tuple):
        of_all = (of_all,) * max(1, len(names))
    preloads = [named.get(name, value) for name, value in zip(names, of_all, strict=False)]
    nominal = case.preload_N or max(preloads or of_all)
    if not any(preloads or of_all):
        return {}, [(("bolt_preloads_N",), "must have one above 0: a bolt that carries the load")]
    ratios = [value / nominal for value in preloads]
    given = case.preload_ratios or (1.0,) * len(ratios)
    changed = {key: value for key, value in content.items() if key != "bolt_preloads_N"}
    changed["preload_N"] = nominal
    # given ones that are not as many as bolts stay, and are refused for that
    if len(given) == len(ratios) and any(ratio != 1 for ratio in ratios):
        changed["preload_ratios"] = [a * b for a, b in zip(ratios, given, strict=True)]
    return changed, []


def conflicts_of_preload(case: Case, assembly: Described | None) -> Problems:
    """Other preloads than bolts, or than the one of loads that are given."""
    if assembly is not None and (given := assembly.given_loads) is not None:
        key, preload = given
        if case.nominal_preload != preload:
            yield ("preload_N",), f"must be {preload:g}, that of {key} of {case.assembly}"
    if assembly is not None and case.preload_ratios is not None:
        bolts = assembly.bolt_count
        if len(case.preload_ratios) != bolts:
            sentence = f"must have {bolts} ratios, one for each bolt of {case.assembly}"
            yield ("preload_ratios",), sentence
            return
        for path, sentence in assembly.conflicts_of_ratios(case.preload_ratios):
            yield ("preload_ratios", *path), sentence


def conflicts_of_surfaces(case: Case, assembly: Described | None) -> Problems:
    """Contact of surfaces that the assembly does not have, or that its modes have already."""
    if assembly is None:
        return
    yield from case.contact.conflicts_of_surfaces(case.assembly, assembly.surface_names)
    if assembly.closes_contact and "normal" in case.contact.declaration.directions:
        yield (
            ("contact", "law"),
            f"must be one under constant normal load: modes of {case.assembly} have the normal "
            "springs of its contact, base: closed",
        )


def conflicts_of_places(case: Case, assembly: Described | None) -> Problems:
    """Places of the excitation and the sensors that the assembly does not have."""
    if assembly is None:
        return
    for path, point in case.points.items():
        yield from ((path + inner, line) for inner, line in assembly.conflicts_of_point(point))
    for path, name in case.named_places.items():
        names = assembly.output_names if path[0] == "outputs" else assembly.input_names
        if name not in names:
            what = "output" if path[0] == "outputs" else "input"
            yield path, f"is no {what} of {case.assembly}{choice(name, names)}"
    excitation = case.excitation
    if excitation is None and not assembly.input_names:
        yield ("excitation",), f"is missing: {case.assembly} names no inputs"
    elif case.is_base_excited and not assembly.has_support:
        yield ("excitation", "kind"), f"must not be base: nothing is said to hold {case.assembly}"
    elif excitation is not None and excitation.kind == "distributed":
        if excitation.surface not in (names := assembly.LOADED_SURFACES):
            sentence = f"is no surface of {case.assembly}{choice(excitation.surface, names)}"
            yield ("excitation", "surface"), sentence
    if not (case.sensors or case.outputs or assembly.output_names):
        yield ("sensors",), f"is missing: {case.assembly} names no outputs"


def conflicts_when_solved(solved: SolvedCase, assembly: Described, settings: Settings) -> Problems:
    """What an assembly and the settings do not allow in a case that is solved as in a sweep."""
    conflicts: Iterable[tuple[KeyPath, str]] = solved.problems
    if solved.case is not None:
        conflicts = conflicts_of_case(solved.case, assembly, settings, None)
    keys = {"joints": "joint", "modes": "basis", "resonance": "resonance"}
    for path, sentence in conflicts:
        key = next((keys[part] for part in path if part in keys), None)
        yield path if key is None else (key,), sentence


def _conflicts_of_joints(case: Case, assembly: Described) -> Problems:
    """Joints with more regions, elements in all or weighted pairs than there are contact pairs.

    Bands hold each pair with its mirror image, and so are at most as many as on one side. Each
    surface has a region at least.
    """
    surfaces = len(assembly.surface_names)
    pairs = assembly.contact_pairs, f"the contact pairs of {case.assembly}"
    of_one_side = assembly.pairs_of_one_side, _pairs_of_one_side(case.assembly, assembly)
    for block_index, block in enumerate(case.solve):
        for index, joint in enumerate(block.joints):
            regions = 1 if joint.count == "auto" else joint.count or 0
            of_regions = of_one_side if joint.division == "regions" else pairs
            for number, what, (most, of_what) in (
                (regions, joint.division, of_regions),
                (regions * (joint.elements or 0), "elements in all", pairs),
                (0 if joint.pairs == "auto" else joint.pairs or 0, "weighted pairs", pairs),
            ):
                if number > most:
                    path = ("solve", block_index, "joints", index)
                    yield path, f"must have at most {most} {what}, {of_what}"
                    break
            count = joint.count
            if joint.division is not None and isinstance(count, int) and count < surfaces:
                path = ("solve", block_index, "joints", index)
                yield path, f"must have at least {surfaces} {joint.division}, one on each surface"


def _conflicts_of_options(case: Case, settings: Settings) -> Problems:
    """Resonances and coordinates that the numerical options do not allow."""
    most, harmonics = settings.contact_adapted_basis.resonances, settings.solver.harmonics
    law = case.contact.declaration
    if not law.has_closed_form and settings.solver.sampling is None:
        sentence = "has no closed form: it needs solver.friction_force: aft"
        yield ("contact", "law"), f"must not be {law.name}, which {sentence} in {CONFIG_FILE}"
    for index, block in enumerate(case.blocks):
        enriched = [basis for basis in block.modes if basis.is_contact_adapted]
        if enriched and block.resonance > most:
            sentence = f"must be at most {most}, contact_adapted_basis.resonances, in {enriched[0]}"
            yield ("solve", index, "resonance"), sentence
        for place, name in enumerate(block.coordinates):
            kinds = {"complex", "backbone"} if harmonics == "auto" else {"complex"}
            if harmonics != 1 and name.kind in kinds:
                path = (*case.place_of("coordinates", index), place)
                allowed = (
                    "linear or rdnm-N" if harmonics == "auto" else "linear, rdnm-N or backbone"
                )
                yield path, f"must be {allowed} with solver.harmonics: {harmonics}"


def _conflicts_of_bases(
    case: Case, assembly: Described | None, options: ContactAdaptedBasis
) -> Problems:
    """Enriched bases of more vectors than are found."""
    for index, block in enumerate(case.blocks):
        for place, basis in enumerate(block.modes):
            sentence = _too_large(basis, options, {case.assembly: assembly})
            if assembly is not None and assembly.has_modes_only and basis.is_contact_adapted:
                sentence = f"must be free-N or all-N: nothing but modes is known of {case.assembly}"
            if sentence:
                yield (*case.place_of("modes", index), place), sentence


def other_preloads(
    cases: Mapping[str, Case],
    assemblies: Mapping[str, Described],
    compared: Collection[Basis],
) -> Iterator[tuple[str, str, str]]:
    """Cases that are tightened otherwise than the contact-adapted basis assumes, with the key.

    Several preloads of an assembly are alike but for a factor, and so is what a basis resolves; of
    an assembly with an initial gap they are not. ``compared`` are the bases of the convergence
    study.
    """
    gapped = {name for name, description in assemblies.items() if description.has_initial_gap}
    enriched = {
        case.assembly
        for case in cases.values()
        for basis in (*case.bases, *(compared if case.assembly in gapped else ()))
        if basis.is_contact_adapted
    }
    for assembly in enriched:
        loads = "loads of one ratio"
        if assembly in gapped:
            loads = f"one preload, with {assemblies[assembly].GAP_KEY}"
        alike = {
            name: Preload.of(case.nominal_preload if assembly in gapped else 1, case.preload_ratios)
            for name, case in cases.items()
            if case.assembly == assembly
        }
        # equal bolts are what the others differ from
        first = min(alike, key=lambda name: isinstance(alike[name].of_bolts, tuple))
        for name, preload in alike.items():
            if preload != alike[first]:
                of_size = assembly in gapped and cases[name].preload_N != cases[first].preload_N
                yield (
                    name,
                    "preload_N" if of_size else "preload_ratios",
                    f"must be as in {first}: a contact-adapted basis of {assembly} is made for "
                    f"{loads}",
                )


def missing_preloads(
    cases: Collection[Case], assemblies: Mapping[str, Described | None]
) -> Iterator[tuple[str, str]]:
    """Assemblies that are to have an enriched basis but no contact to make it from."""
    used = {case.assembly for case in cases}
    enriched = [basis for case in cases for basis in case.bases if basis.is_contact_adapted]
    for name, assembly in assemblies.items():
        if enriched and assembly and name not in used and assembly.own_preload is None:
            yield name, f"is missing: {enriched[0]} is made from the contact under preload"


def conflicts_of_convergence(
    settings: Settings,
    cases: Collection[Case | None],
    assemblies: Mapping[str, Described | None],
) -> Problems:
    """Bases and numbers of regions that an assembly does not have."""
    for index, basis in enumerate(settings.convergence.bases):
        if sentence := _too_large(basis, settings.contact_adapted_basis, assemblies):
            yield ("convergence", "bases", index), sentence
    divided = {
        case.assembly
        for case in cases
        if case and any(basis.is_contact_adapted for basis in case.bases)
    }
    for index, count in enumerate(settings.convergence.regions):
        for name, assembly in assemblies.items():
            if name in divided and assembly and count > (most := assembly.pairs_of_one_side):
                sentence = f"must be at most {most}, {_pairs_of_one_side(name, assembly)}"
                yield ("convergence", "regions", index), sentence
                break


def _too_large(
    basis: Basis, options: ContactAdaptedBasis, assemblies: Mapping[str, Described | None]
) -> str | None:
    """What an enriched basis of more vectors than are found must be, for the first assembly."""
    if not basis.is_contact_adapted or basis.vectors == "auto":
        return None
    number, most = basis.vectors, options.maximum_vectors
    if number > most:
        return (
            f"must have at most {most} vectors, as contact_adapted_basis.maximum_vectors in "
            f"{CONFIG_FILE}"
        )
    for name, assembly in assemblies.items():
        # candidates: modes, and the shapes of a force along and across the contact on every pair
        if assembly and number > (
            candidates := options.free_modes + 2 * assembly.pairs_of_one_side
        ):
            return (
                f"must have at most {candidates} vectors: contact_adapted_basis.free_modes, "
                f"and two for each of {_pairs_of_one_side(name, assembly)}"
            )
    return None


def _pairs_of_one_side(name: str, assembly: Described) -> str:
    if not assembly.has_mirror_images:
        return f"the contact points of {name}"
    return f"the contact pairs of {name} on one side of the centre line and on it"
