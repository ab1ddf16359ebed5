"""The tables of a case in a basis, each from the results that it shows."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import pandas as pd
import xarray as xr

from boltjoint.names import REFERENCE, JointName
from boltjoint.study.published import Published
from boltjoint.study.results import Results
from boltjoint.study.tables.accuracy import tabulate_accuracy
from boltjoint.study.tables.joints import (
    tabulate_elements,
    tabulate_fits,
    tabulate_regions,
    tabulate_states,
)
from boltjoint.study.tables.times import tabulate_times

if TYPE_CHECKING:
    from boltjoint.study.artefact_list import Artefact, Response


@dataclass(frozen=True)
class BasisTables:
    """What the tables of a case in a basis are made from.

    Parameters
    ----------
    results
        Joints, responses, timings and checks.
    case, basis
        Their names.
    responses
        All responses in this basis.
    published
        The source's tables of the case.
    """

    results: Results
    case: str
    basis: str
    responses: "Sequence[Response]"
    published: Published

    def tabulate(self, artefact: "Artefact") -> tuple[pd.DataFrame, str]:
        """A table and its title."""
        make, title = _TABLES[artefact.kind]
        words = {"case": self.case, "basis": self.basis, "joint": artefact.joint}
        return make(self, artefact), title.format(**words)

    def accuracy(self, _: "Artefact") -> pd.DataFrame:
        """Errors of all responses, with the residuals in time where they were found."""
        checks = {
            response[1:]: self.results.data("check", **self._which(response))
            for response in self.responses
            if self.results.has("check", **self._which(response))
        }
        return tabulate_accuracy(self._of_responses(self.responses), checks)

    def states(self, _: "Artefact") -> pd.DataFrame:
        """Contact states at the peaks."""
        joints = dict.fromkeys(response.joint for response in self.responses)
        return tabulate_states(
            self._of_responses(self.responses), {joint: self._joint(joint) for joint in joints}
        )

    def times(self, _: "Artefact") -> pd.DataFrame:
        """Solution times."""
        timings = {
            response[1:]: self.results.data("timing", **self._which(response))
            for response in self.responses
        }
        return tabulate_times(timings, self.published)

    def fits(self, _: "Artefact") -> pd.DataFrame:
        """Cost and errors of fitted elements."""
        linear = [each for each in self.responses if each[2:] == (REFERENCE[1], 1)]
        joints = dict.fromkeys(each.joint for each in self.responses)
        fitted = [joint for joint in joints if joint.elements is not None]
        return tabulate_fits(
            {joint: self._joint(joint) for joint in fitted},
            {joint: self.results.data("fit_timing", **self._of_joint(joint)) for joint in fitted},
            {each.joint: found for each, found in zip(linear, self._load(linear), strict=True)},
        )

    def regions(self, artefact: "Artefact") -> pd.DataFrame:
        """Elements, load and stiffness of regions."""
        return tabulate_regions(self._joint(artefact.joint))

    def elements(self, artefact: "Artefact") -> pd.DataFrame:
        """Fitted elements beside the published ones."""
        return tabulate_elements(self._joint(artefact.joint), artefact.joint, self.published)

    def _of_joint(self, joint: JointName) -> dict[str, str]:
        return {"case": self.case, "basis": self.basis, "joint": joint}

    def _joint(self, joint: JointName) -> xr.Dataset:
        return self.results.dataset("joint", **self._of_joint(joint))

    def _which(self, response: "Response") -> dict[str, object]:
        return {"case": self.case, **response._asdict()}

    def _load(self, responses: "Sequence[Response]") -> list[xr.Dataset]:
        return [self.results.dataset("response", **self._which(each)) for each in responses]

    def _of_responses(self, responses: "Sequence[Response]") -> dict[tuple, xr.Dataset]:
        return {
            each[1:]: found for each, found in zip(responses, self._load(responses), strict=True)
        }


_TABLES: dict[str, "tuple[Callable[[BasisTables, Artefact], pd.DataFrame], str]"] = {
    "accuracy": (BasisTables.accuracy, "{case}: accuracy in {basis}"),
    "states": (BasisTables.states, "{case}: contact states at the peaks in {basis}"),
    "times": (BasisTables.times, "{case}: solution times in {basis}"),
    "fits": (BasisTables.fits, "{case}: fits of elements"),
    "regions": (BasisTables.regions, "{case}: {joint}"),
    "elements": (BasisTables.elements, "{case}: elements of {joint}"),
}
