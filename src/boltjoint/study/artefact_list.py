"""The contents of a study: one list of all files that it makes."""

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice
from typing import TYPE_CHECKING, Any, Literal, Protocol

from boltjoint.names import PAGES, REFERENCE, Basis, Coordinates, JointName, Preload
from boltjoint.study import layout
from boltjoint.study.response_list import Responses, headline_basis, with_regions

if TYPE_CHECKING:
    from boltjoint.config.study import Study
    from boltjoint.config.sweep import Sweep
    from boltjoint.config.varied_case import Variant


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
    def fields(self) -> dict[str, Any]:
        """What the file is of."""
        # the first two are not; ``dataclasses.fields`` takes its time, of all files of a study
        values = islice(vars(self).items(), 2, None)
        return {name: value for name, value in values if value is not None}

    @property
    def path(self) -> str:
        """The file; of a table the CSV, of a page that which stands by itself."""
        if self.form == "data":
            return layout.path(self.kind, **self.fields)
        if self.form == "page":
            return layout.page(self.kind)
        return layout.shown(self.form, self.kind, **self.fields)

    @property
    def paths(self) -> tuple[str, ...]:
        """All files that are made together with it."""
        path = self.path
        if self.form == "table":
            html = layout.shown("html", self.kind, **self.fields)
            return path, html, layout.beside(path)
        if self.form == "page":
            return path, layout.page(self.kind, packed=True)
        if path.endswith((".csv", ".json")):
            return path, layout.beside(path)
        return (path,)


def _solved_of(
    sweep: "Sweep", variant: "Variant", *, checking: bool
) -> tuple[Basis, list[JointName]]:
    """Basis and joints of a variant of a sweep, or of its check.

    Node to node first, which knows limits of the model, and last the one that is solved.
    """
    basis, joint = sweep.basis, variant.joint
    if checking and sweep.check is not None:
        basis, joint = sweep.check.basis, sweep.check.joint
    return basis, list(dict.fromkeys([REFERENCE[0], *with_regions([joint])]))


def _swept_joint(name: str, case: str, basis: Basis, joint: JointName) -> Artefact:
    """A joint of a variant of a sweep: weights of pairs are made for its designs."""
    made = Artefact("joint", case=case, basis=basis, joint=joint)
    return made if joint.pairs is None else replace(made, kind="weighted_joint", sweep=name)


def _joints_of_sweep(study: "Study", name: str) -> Iterator[Artefact]:
    """The joints of a sweep and of its check, and what they are made from."""
    sweep = study.sweeps[name]
    for variant in study.possible_variants(name):
        assembly, case = variant.assembly_name, variant.case_name
        for kind in ("assembly", "structure", "mesh_view"):
            yield Artefact(kind, assembly=assembly)
        for kind in ("preload", "preload_view"):
            yield Artefact(kind, preload_N=variant.case.preload, assembly=assembly)
        for checking in (False, True) if sweep.check is not None else (False,):
            basis, joints = _solved_of(sweep, variant, checking=checking)
            for kind in ("modes", "modes_view"):
                yield Artefact(kind, basis=basis, assembly=assembly)
            if basis.is_contact_adapted:
                yield Artefact("pod_modes", assembly=assembly)
            for joint in joints:
                yield _swept_joint(name, case, basis, joint)
                if joint.reduction is not None:
                    yield Artefact("fit_timing", case=case, basis=basis, joint=joint)


class Listed(Protocol):
    """What a study has several of, such as a figure (``study.display.Display``)."""

    def artefacts(self, contents: "Contents") -> Iterator[Artefact]:
        """All of this kind that a study has."""


class Contents(Responses):
    """Everything that a study makes.

    Parameters
    ----------
    study
        The study, as it is configured.
    displays
        The figures and tables that studies have.
    timed
        As for ``Responses``.
    """

    def __init__(
        self,
        study: "Study",
        displays: "Iterable[Listed]" = (),
        timed: Mapping[str, Collection[str]] | None = None,
    ) -> None:
        super().__init__(study, timed)
        self._displays = tuple(displays)

    @cached_property
    def artefacts(self) -> tuple[Artefact, ...]:
        """Everything, with the joints of sweeps and what they are made from."""
        names = self.study.sweeps
        chunks = [artefact for name in names for artefact in self._chunks(name)]
        # a case's own results must not depend on the joints that a sweep adds to it
        joints = [artefact for name in names for artefact in _joints_of_sweep(self.study, name)]
        return tuple(dict.fromkeys([*self._results, *chunks, *self._displayed, *joints]))

    @cached_property
    def _results(self) -> tuple[Artefact, ...]:
        """The data, without the chunks and joints of sweeps."""
        return tuple(self._data())

    @cached_property
    def _displayed(self) -> tuple[Artefact, ...]:
        """The figures, tables and pages."""
        return tuple(dict.fromkeys([*self._shown(), *self._pages()]))

    @cached_property
    def _of_kind(self) -> defaultdict[str, list[Artefact]]:
        """The artefacts by kind, without the chunks of sweeps, which are counted when needed."""
        artefacts: defaultdict[str, list[Artefact]] = defaultdict(list)
        for artefact in dict.fromkeys([*self._results, *self._displayed]):
            artefacts[artefact.kind].append(artefact)
        return artefacts

    def select(self, *kinds: str, **fields: object) -> list[Artefact]:
        """The artefacts of these kinds, or of all, and with these values of their fields.

        Without the joints of sweeps, and what these are made from.
        """
        candidates: Iterable[Artefact]
        if kinds:
            candidates = [
                candidate for kind in kinds for candidate in self._all_of(kind, fields.get("sweep"))
            ]
        else:
            candidates = self._displayed if fields.get("form", "data") != "data" else self.artefacts
        return [
            artefact
            for artefact in candidates
            if all(getattr(artefact, name) == value for name, value in fields.items())
        ]

    def first_response(self, case: str, form: str) -> list[Artefact]:
        """The response of a case around its first resonance in its most trusted basis."""
        configured = self.study.case(case)
        basis = headline_basis(configured)
        joint, coordinates = REFERENCE
        fields = {"basis": basis, "joint": joint, "coordinates": coordinates}
        resonance = configured.resonances(basis)[0]
        return self.select("response", form=form, case=case, resonance=resonance, **fields)

    def _all_of(self, kind: str, sweep: object = None) -> Iterable[Artefact]:
        """The artefacts of a kind, at least those of a sweep if one is named."""
        if kind != "chunk":
            return self._of_kind[kind]
        names = self.study.sweeps if sweep is None else [str(sweep)]
        return [artefact for name in names for artefact in self._chunks(name)]

    def files(self, *kinds: str, **fields: object) -> list[str]:
        """The files of these kinds, with those made together with them; of no kind, all."""
        artefacts = self.select(*kinds, **fields) if kinds or fields else self.artefacts
        return [path for artefact in artefacts for path in artefact.paths]

    def _data(self) -> Iterator[Artefact]:
        yield Artefact("environment")
        for name in self.study.assemblies:
            compared = name in self.compared_assemblies()
            bases = [*self.bases(), *(self.study.convergence.bases if compared else ())]
            for kind in ("assembly", "structure", "mesh_view"):
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
        if self.study.sweeps[name].check is not None:
            yield Artefact("sweep_check", sweep=name)
        yield Artefact("sweep", sweep=name)
        yield Artefact("sweep_page", sweep=name)

    def _chunks(self, name: str) -> Iterator[Artefact]:
        """Designs of a sweep that a job solves."""
        for chunk in range(self.chunks(name)):
            yield Artefact("chunk", sweep=name, chunk=chunk)

    def joints_of_sweep(self, name: str, *, checking: bool = False) -> list[list[str]]:
        """Files of the joints of each variant of a sweep: node to node, and reduced from it.

        Those that its check solves, or those of its designs.
        """
        files = []
        for variant in self.study.possible_variants(name):
            basis, joints = _solved_of(self.study.sweeps[name], variant, checking=checking)
            of_variant = name, variant.case_name, basis
            files.append([_swept_joint(*of_variant, joint).path for joint in joints])
        return files

    def bases_of_weights(self, name: str) -> list[Basis]:
        """Of each joint whose weights are made for a sweep: for its designs, or for its check."""
        joints = dict.fromkeys(_joints_of_sweep(self.study, name))
        weighted = (each for each in joints if each.kind == "weighted_joint")
        return [each.basis for each in weighted if each.basis is not None]

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
        reduced, converged = self.reduced(case), self.converged(case)
        if reduced and converged is not None:
            joints.append((converged.basis, with_regions(reduced)))
        for basis, of_basis in joints:
            for joint in of_basis:
                yield Artefact("joint", case=case, basis=basis, joint=joint)
                if joint.reduction is not None:
                    yield Artefact("fit_timing", case=case, basis=basis, joint=joint)
        if (measured := self.study.case(case).measured) is not None:
            predicted = ("prediction",) if measured.predicted else ()
            for kind in ("calibration", "fitted_case", *predicted):
                yield Artefact(kind, **self.calibrated(case))
        checked, by_differences = set(self.checked(case)), set(self.by_differences(case))
        for response in self.responses(case):
            fields = {"case": case, **response._asdict()}
            yield Artefact("response", **fields)
            yield Artefact("timing", **fields)
            if response in by_differences:
                yield Artefact("forward_differences", **fields)
            if response in checked:
                yield Artefact("check", **fields)
            if fields.pop("coordinates").kind == "backbone":
                yield Artefact("backbone", **fields)

    def _shown(self) -> Iterator[Artefact]:
        for display in self._displays:
            yield from display.artefacts(self)

    def _pages(self) -> Iterator[Artefact]:
        for name in (*PAGES, *self.study.cases):
            yield Artefact(name, "page")
