"""The responses of a study: what is solved, compared, checked and timed, and bases by trust."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from boltjoint.config.case import Case
from boltjoint.config.conflicts_of_measured import calibrated_joint
from boltjoint.names import REFERENCE, Basis, Coordinates, JointName, Preload

if TYPE_CHECKING:
    from boltjoint.config.study import Study


def by_trust(bases: Sequence[Basis]) -> list[Basis]:
    """Contact-adapted bases first, the largest before all; then the others."""
    return sorted(bases, key=lambda basis: (basis.is_contact_adapted, basis.most), reverse=True)


def headline_basis(case: Case) -> Basis:
    """The basis of a case whose peaks stand first."""
    return by_trust(case.bases)[0]


class Response(NamedTuple):
    """The frequency responses of a joint around a resonance."""

    basis: Basis
    joint: JointName
    coordinates: Coordinates
    resonance: int


def with_regions(joints: Iterable[JointName]) -> list[JointName]:
    """Joints after those of regions that they are reduced from, each once."""
    joints = list(joints)
    regions = [joint.regions for joint in joints if joint.division is not None]
    return list(dict.fromkeys([*regions, *joints]))


class Responses:
    """What is solved of the cases of a study.

    Parameters
    ----------
    study
        The study, as it is configured.
    timed
        Joints of each case study of the source whose times it has around the first resonance; by
        default it has those of all.
    """

    def __init__(self, study: "Study", timed: Mapping[str, Collection[str]] | None = None) -> None:
        self.study, self._timed = study, timed
        self._responses: dict[str, dict[str | None, list[Response]]] = {}
        self._joints: dict[tuple[str, str], list[JointName]] = {}

    def cases_and_bases(self) -> list[tuple[str, Basis]]:
        """Every case with every basis that it is solved in."""
        return [(name, basis) for name, case in self.study.cases.items() for basis in case.bases]

    def responses(self, case: str, basis: str | None = None) -> list[Response]:
        """All responses of a case, or of those in one basis."""
        if case not in self._responses:
            responses = [Response(*response) for response in self.study.case(case).responses]
            self._responses[case] = {None: responses}
            for response in responses:
                self._responses[case].setdefault(response.basis, []).append(response)
        return self._responses[case].get(basis, []).copy()

    def references(self, case: str) -> list[Response]:
        """The responses of the node-to-node joint of a case in linear modes."""
        return [response for response in self.responses(case) if response[1:3] == REFERENCE]

    def joints(self, case: str, basis: str) -> list[JointName]:
        """The joints that are solved in a basis, and those of regions they are reduced from."""
        if (case, basis) not in self._joints:
            joints = self.study.case(case).joints(basis)
            self._joints[case, basis] = with_regions([REFERENCE[0], *joints])
        return self._joints[case, basis].copy()

    def fitted(self, case: str, basis: str) -> list[JointName]:
        """The joints of a case and basis whose elements are fitted."""
        return [joint for joint in self.joints(case, basis) if joint.is_fitted]

    def calibrated(self, case: str) -> dict[str, Any]:
        """Case, basis and joint whose parameters are fitted to a measurement."""
        return calibrated_joint(case, self.study.case(case))

    def integrated(self, case: str) -> Response | None:
        """The response whose peaks are checked by time integration: the first in free modes."""
        if "harmonics" in self.study.omit or not self.study.case(case).verification_forces_N:
            return None
        references = self.lowest_references(case).values()
        return next((one for one in references if not one.basis.is_contact_adapted), None)

    def integrated_levels(self, case: str) -> list[float]:
        """The forces of a case at which its converged peaks are integrated in time."""
        wanted = self.study.convergence.time_integration_N
        return [force for force in self.study.case(case).levels if force in wanted]

    def bases_of_integration(self, case: str) -> list[Basis]:
        """Bases of converged peaks at these forces: the converged one and, if any, a larger one."""
        if not (self.integrated_levels(case) and (converged := self.converged(case))):
            return []
        own, last = converged.basis, self.study.convergence.bases[-1:]
        return [own, *(basis for basis in last if basis.fewest > own.most)]

    def lowest_references(self, case: str) -> dict[str, Response]:
        """By basis, the response of the node-to-node joint of the lowest mode."""
        lowest: dict[str, Response] = {}
        for response in sorted(self.references(case), key=lambda one: one.resonance):
            lowest.setdefault(response.basis, response)
        return lowest

    def converged(self, case: str) -> Response | None:
        """The response that comes closest to the structure: node-to-node, in the largest basis.

        A basis of as many vectors as a tolerance asks for counts as the largest.
        Of contact-adapted bases, around the first resonance.
        """
        first = (one for one in self.references(case) if one.resonance == 1)
        references = (one for one in first if one.basis.is_contact_adapted)
        return max(references, key=lambda one: one.basis.most, default=None)

    def compared(self, case: str) -> list[Response]:
        """The responses of a case around the resonance of its converged one."""
        converged = self.converged(case)
        if converged is None:
            return []
        return [one for one in self.responses(case) if one.resonance == converged.resonance]

    def is_compared(self, case: str | None = None) -> bool:
        """Whether a case, or any of them, is compared with a published one."""
        cases = self.study.cases.values() if case is None else [self.study.case(case)]
        return any(one.published is not None for one in cases)

    def by_differences(self, case: str, basis: str | None = None) -> list[Response]:
        """The responses that are timed with forward differences too, as the source timed them."""
        is_left_out = "timing" in self.study.omit or not self.is_compared(case)
        if is_left_out or self.study.solver.jacobian == "forward-difference":
            return []
        return [
            response
            for response in self.responses(case, basis)
            if not response.basis.is_contact_adapted
            and response.joint.is_published
            and response.coordinates.kind in ("linear", "real")
            and self._is_timed(case, response)
        ]

    def _is_timed(self, case: str, response: Response) -> bool:
        """Whether the source has times of a response."""
        if self._timed is None:
            return True
        joints = self._timed.get(self.study.case(case).published or "", ())
        return response.joint in joints and response.resonance == 1

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
            (name, preload)
            for name, described in self.study.assemblies.items()
            if all(name != assembly for assembly, _ in used)
            and (preload := described.own_preload) is not None
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
        bases: list[Basis] = list(self.study.convergence.bases)
        converged = self.converged(case)
        if self.study.convergence.regions and converged:
            bases.append(converged.basis)
        return bases

    def backbones(self, case: str, basis: str, resonance: int) -> list[JointName]:
        """The joints of a case whose backbone of a resonance is traced."""
        return [
            one.joint
            for one in self.responses(case, basis)
            if one.coordinates.kind == "backbone" and one.resonance == resonance
        ]
