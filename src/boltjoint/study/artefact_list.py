"""The contents of a study: its responses, and one list of all files that it makes."""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Literal, NamedTuple

from boltjoint.names import PAGES, REFERENCE, Basis, Coordinates, JointName, Preload
from boltjoint.study import layout

if TYPE_CHECKING:
    from boltjoint.config.study import Study
    from boltjoint.study.display import Display


class Response(NamedTuple):
    """The frequency responses of a joint around a resonance."""

    basis: Basis
    joint: JointName
    coordinates: Coordinates
    resonance: int


@dataclass(frozen=True)
class Artefact:
    """A file of a study.

    ``kind`` is what it holds or shows; ``form`` the sort of file; the rest is what it is of, None
    where it is of all.
    """

    kind: str
    form: Literal["data", "figure", "table", "page"] = "data"
    assembly: str | None = None
    preload_N: Preload | None = None  # noqa: N815
    case: str | None = None
    basis: Basis | None = None
    joint: JointName | None = None
    coordinates: Coordinates | None = None
    resonance: int | None = None
    sweep: str | None = None
    chunk: int | None = None

    @property
    def which(self) -> dict[str, object]:
        """What the file is of."""
        values = ((field.name, getattr(self, field.name)) for field in fields(self)[2:])
        return {name: value for name, value in values if value is not None}

    @property
    def path(self) -> str:
        """The file; of a table the CSV, of a page that which stands by itself."""
        if self.form == "data":
            return layout.path(self.kind, **self.which)
        if self.form == "page":
            return layout.page(self.kind)
        return layout.shown(self.form, self.kind, **self.which)

    @property
    def paths(self) -> tuple[str, ...]:
        """All files that are made together with it."""
        if self.form == "table":
            html = layout.shown("html", self.kind, **self.which)
            return self.path, html, layout.beside(self.path)
        if self.form == "page":
            return self.path, layout.page(self.kind, packed=True)
        if self.path.endswith((".csv", ".json")):
            return self.path, layout.beside(self.path)
        return (self.path,)


def with_regions(joints: "Iterable[JointName]") -> list[JointName]:
    """Joints after those of regions that they are reduced from, each once."""
    joints = list(joints)
    regions = [joint.regions for joint in joints if joint.division is not None]
    return list(dict.fromkeys([*regions, *joints]))


def _joints_of_sweep(study: "Study", name: str) -> Iterator[Artefact]:
    """The joints of a sweep, and what they are made from."""
    basis = study.sweeps[name].basis
    for variant in study.possible_variants(name):
        of_assembly = {"assembly": variant.assembly_name}
        for kind in ("assembly", "mesh_view"):
            yield Artefact(kind, **of_assembly)
        for kind in ("modes", "modes_view"):
            yield Artefact(kind, basis=basis, **of_assembly)
        if basis.is_contact_adapted:
            yield Artefact("pod_modes", **of_assembly)
        for kind in ("preload", "preload_view"):
            yield Artefact(kind, preload_N=variant.case.preload, **of_assembly)
        for joint in with_regions([REFERENCE[0], variant.joint]):
            which = {"case": variant.case_name, "basis": basis, "joint": joint}
            yield Artefact("joint", **which)
            if joint.reduction is not None:
                yield Artefact("fit_timing", **which)


class Contents:
    """Everything that a study makes.

    Parameters
    ----------
    study
        The study, as it is configured.
    displays
        The figures and tables that studies have.
    """

    def __init__(self, study: "Study", displays: "Iterable[Display]" = ()) -> None:
        self.study = study
        self._displays = tuple(displays)
        self._responses: dict[str, list[Response]] = {}

    @cached_property
    def artefacts(self) -> tuple[Artefact, ...]:
        """Everything, with the joints of sweeps and what they are made from."""
        names = self.study.sweeps
        chunks = [each for name in names for each in self._chunks(name)]
        # a case's own results must not depend on the joints that a sweep adds to it
        joints = [each for name in names for each in _joints_of_sweep(self.study, name)]
        return tuple(dict.fromkeys([*self._data(), *chunks, *self._displayed, *joints]))

    @cached_property
    def _displayed(self) -> tuple[Artefact, ...]:
        """The figures, tables and pages."""
        return tuple(dict.fromkeys([*self._shown(), *self._pages()]))

    @cached_property
    def _of_kind(self) -> defaultdict[str, list[Artefact]]:
        """The artefacts by kind, without the chunks of sweeps, which are counted when needed."""
        found: defaultdict[str, list[Artefact]] = defaultdict(list)
        for artefact in dict.fromkeys([*self._data(), *self._displayed]):
            found[artefact.kind].append(artefact)
        return found

    def select(self, *kinds: str, **which: object) -> list[Artefact]:
        """The artefacts of these kinds, or of all, and with these values of their fields.

        Without the joints of sweeps, and what these are made from.
        """
        if kinds:
            found = [each for kind in kinds for each in self._all_of(kind, which.get("sweep"))]
        else:
            found = self._displayed if which.get("form", "data") != "data" else self.artefacts
        return [
            artefact
            for artefact in found
            if all(getattr(artefact, name) == value for name, value in which.items())
        ]

    def _all_of(self, kind: str, sweep: object = None) -> Iterable[Artefact]:
        """The artefacts of a kind, at least those of a sweep if one is named."""
        if kind != "chunk":
            return self._of_kind[kind]
        names = self.study.sweeps if sweep is None else [sweep]
        return [each for name in names for each in self._chunks(name)]

    def files(self, *kinds: str, **which: object) -> list[str]:
        """The files of these kinds, with those made together with them; of no kind, all."""
        found = self.select(*kinds, **which) if kinds or which else self.artefacts
        return [path for artefact in found for path in artefact.paths]

    def cases_and_bases(self) -> list[tuple[str, Basis]]:
        """Every case with every basis that it is solved in."""
        return [(name, basis) for name, case in self.study.cases.items() for basis in case.bases]

    def responses(self, case: str, basis: str | None = None) -> list[Response]:
        """All responses of a case, or of those in one basis."""
        if case not in self._responses:
            self._responses[case] = [Response(*each) for each in self.study.case(case).responses]
        return [each for each in self._responses[case] if basis in (None, each.basis)]

    def references(self, case: str) -> list[Response]:
        """The responses of the node-to-node joint of a case in linear modes."""
        return [each for each in self.responses(case) if each[1:3] == REFERENCE]

    def joints(self, case: str, basis: str) -> list[JointName]:
        """The joints that are solved in a basis, and those of regions they are reduced from."""
        return with_regions([REFERENCE[0], *self.study.case(case).joints(basis)])

    def fitted(self, case: str, basis: str) -> list[JointName]:
        """The joints of a case and basis whose elements are fitted."""
        return [joint for joint in self.joints(case, basis) if joint.is_fitted]

    def integrated(self, case: str) -> Response | None:
        """The response whose peaks are checked by time integration: the first in free modes."""
        if "harmonics" in self.study.omit or not self.study.case(case).verification_forces_N:
            return None
        found = self.lowest_references(case).values()
        return next((one for one in found if not one.basis.is_contact_adapted), None)

    def integrated_levels(self, case: str) -> list[float]:
        """The forces of a case at which its converged peaks are integrated in time."""
        wanted = self.study.convergence.time_integration_N
        return [force for force in self.study.case(case).levels if force in wanted]

    def bases_of_integration(self, case: str) -> list[Basis]:
        """Bases of converged peaks at these forces: the converged one and, if any, a larger one."""
        if not (self.integrated_levels(case) and (converged := self.converged(case))):
            return []
        own, last = converged.basis, self.study.convergence.bases[-1:]
        return [own, *(each for each in last if each.fewest > own.most)]

    def lowest_references(self, case: str) -> dict[str, Response]:
        """By basis, the response of the node-to-node joint of the lowest mode."""
        found: dict[str, Response] = {}
        for response in sorted(self.references(case), key=lambda one: one.resonance):
            found.setdefault(response.basis, response)
        return found

    def converged(self, case: str) -> Response | None:
        """The response that comes closest to the structure: node-to-node, in the largest basis.

        A basis of as many vectors as a tolerance asks for counts as the largest.
        Of contact-adapted bases, around the first resonance.
        """
        first = (one for one in self.references(case) if one.resonance == 1)
        found = (one for one in first if one.basis.is_contact_adapted)
        return max(found, key=lambda one: one.basis.most, default=None)

    def compared(self, case: str) -> list[Response]:
        """The responses of a case around the resonance of its converged one."""
        resonance = self.converged(case).resonance
        return [one for one in self.responses(case) if one.resonance == resonance]

    def is_compared(self, case: str | None = None) -> bool:
        """Whether a case, or any of them, is compared with a published one."""
        cases = self.study.cases.values() if case is None else [self.study.case(case)]
        return any(each.published is not None for each in cases)

    def jacobians(self, case: str, response: Response) -> list[str]:
        """The Jacobians that are timed: forward differences too for what the source solves."""
        in_source = (
            self.is_compared(case)
            and not response.basis.is_contact_adapted
            and response.joint.is_published
            and response.coordinates.kind in ("linear", "real")
        )
        return ["analytic", *(["forward-difference"] if in_source else [])]

    def checked(self, case: str, basis: str | None = None) -> list[Response]:
        """The responses whose residual in time is found: all equations solved, forces analytic."""
        if "checks" in self.study.omit or self.study.solver.sampling is not None:
            return []
        return [one for one in self.responses(case, basis) if one.coordinates.kind == "linear"]

    def bases(self) -> list[Basis]:
        """Every basis that a case uses."""
        return list(dict.fromkeys(basis for _, basis in self.cases_and_bases()))

    def preloads(self) -> list[tuple[str, Preload]]:
        """Every assembly with every preload that it is tightened to.

        An assembly that no case uses is tightened to its own preload.
        """
        every = (self.study.cases | self.study.base_cases).values()
        used = [(case.assembly, case.preload) for case in every]
        nominal = [
            (name, Preload.of(found.preload_N))
            for name, found in self.study.assemblies.items()
            if found.preload_N is not None and all(name != assembly for assembly, _ in used)
        ]
        return list(dict.fromkeys(used + nominal))

    def compared_assemblies(self) -> list[str]:
        """The assemblies in whose resonances bases are compared: those of cases, if any are."""
        used = [case.assembly for case in self.study.cases.values()]
        return list(dict.fromkeys(used)) if self.study.convergence.bases else []

    def reduced(self, case: str) -> list[JointName]:
        """The joints that are compared with all pairs of a case in its converged basis."""
        if not self.converged(case):
            return []
        capabilities = self.study.case(case).contact.declaration.capabilities
        wanted = self.study.convergence.reductions
        return [joint for joint in wanted if not joint.missing(capabilities)]

    def compared_bases(self, case: str) -> list[Basis]:
        """The bases in which only the peaks of a case are found."""
        found = list(self.study.convergence.bases)
        converged = self.converged(case)
        if self.study.convergence.regions and converged:
            found.append(converged.basis)
        return found

    def _data(self) -> Iterator[Artefact]:
        yield Artefact("environment")
        for name in self.study.assemblies:
            compared = name in self.compared_assemblies()
            bases = [*self.bases(), *(self.study.convergence.bases if compared else ())]
            for kind in ("assembly", "mesh_view"):
                yield Artefact(kind, assembly=name)
            for basis in bases:
                for kind in ("modes", "modes_view"):
                    yield Artefact(kind, assembly=name, basis=basis)
            if any(basis.is_contact_adapted for basis in bases):
                yield Artefact("pod_modes", assembly=name)
            if compared:
                yield Artefact("patterns", assembly=name)
        for name, preload in self.preloads():
            for kind in ("preload", "preload_view"):
                yield Artefact(kind, assembly=name, preload_N=preload)
        for case in self.study.cases:
            yield from self._data_of_case(case)
        for name in self.study.sweeps:
            yield from self._data_of_sweep(name)

    def _data_of_sweep(self, name: str) -> Iterator[Artefact]:
        yield Artefact("designs", sweep=name)
        yield Artefact("sweep", sweep=name)
        yield Artefact("sweep_page", sweep=name)

    def _chunks(self, name: str) -> Iterator[Artefact]:
        """Designs of a sweep that a job solves."""
        for chunk in range(self.chunks(name)):
            yield Artefact("chunk", sweep=name, chunk=chunk)

    def joints_of_sweep(self, name: str) -> list[list[str]]:
        """Files of the joints of each variant of a sweep: node to node, and reduced from it."""
        basis = self.study.sweeps[name].basis
        return [
            [
                layout.path("joint", case=variant.case_name, basis=basis, joint=joint)
                for joint in with_regions([REFERENCE[0], variant.joint])
            ]
            for variant in self.study.possible_variants(name)
        ]

    def chunks(self, sweep: str) -> int:
        """Number of jobs that solve the designs of a sweep."""
        return -(-self.study.swept[sweep].number // self.study.sweeps[sweep].designs_per_job)

    def chunk(self, sweep: str, number: int) -> tuple[int, int]:
        """The first of the designs that a job solves, and the first of the next job."""
        size = self.study.sweeps[sweep].designs_per_job
        return number * size, min((number + 1) * size, self.study.swept[sweep].number)

    def _data_of_case(self, case: str) -> Iterator[Artefact]:
        for basis in self.compared_bases(case):
            for kind in ("joint", "peaks"):
                yield Artefact(kind, case=case, basis=basis, joint=REFERENCE[0])
        joints = [(basis, self.joints(case, basis)) for basis in self.study.case(case).bases]
        if reduced := self.reduced(case):
            joints.append((self.converged(case).basis, with_regions(reduced)))
        for basis, of_basis in joints:
            for joint in of_basis:
                yield Artefact("joint", case=case, basis=basis, joint=joint)
                if joint.reduction is not None:
                    yield Artefact("fit_timing", case=case, basis=basis, joint=joint)
        checked = self.checked(case)
        for response in self.responses(case):
            which = {"case": case, **response._asdict()}
            yield Artefact("response", **which)
            if "timing" not in self.study.omit:
                yield Artefact("timing", **which)
            if response in checked:
                yield Artefact("check", **which)
            if which.pop("coordinates").kind == "backbone":
                yield Artefact("backbone", **which)

    def _shown(self) -> Iterator[Artefact]:
        for display in self._displays:
            yield from display.artefacts(self)

    def backbones(self, case: str, basis: str, resonance: int) -> list[JointName]:
        """The joints of a case whose backbone of a resonance is traced."""
        return [
            one.joint
            for one in self.responses(case, basis)
            if one.coordinates.kind == "backbone" and one.resonance == resonance
        ]

    def _pages(self) -> Iterator[Artefact]:
        for name in (*PAGES, *self.study.cases):
            yield Artefact(name, "page")
