"""What is kept of the designs of a sweep that a job solves."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.dataset import quantity
from boltjoint.dynamics.balance.modal_contact import ModalContact
from boltjoint.dynamics.response.converged_peaks import ConvergedPeak
from boltjoint.dynamics.response.curves import amplitude_on_grid
from boltjoint.friction import contact_states
from boltjoint.joint.model import Joint

if TYPE_CHECKING:
    from boltjoint.dynamics.response.branch import Branch

Array = NDArray[np.float64]

#: of the peaks with all harmonics
_CONVERGED = (
    ("peak_frequency_converged", "Hz", "peak with as many harmonics as change nothing"),
    ("peak_amplitude_converged", "m", "its amplitude with as many harmonics as change nothing"),
    ("peak_harmonics", "1", "highest of these harmonics"),
    ("peak_frequency_truncation_error", "1", "of the converged peak"),
    ("peak_amplitude_truncation_error", "1", "of its amplitude"),
)


class ObservedDesigns:
    """What is kept of the designs of a chunk.

    Peaks only, with neither frequencies ``grid`` [Hz], amplitudes ``sizes`` [m] nor elements.
    """

    def __init__(
        self,
        designs: int,
        levels: int,
        grid: Array | None,
        sizes: Array | None,
        elements: int | None,
        *,
        converged: bool = False,
    ) -> None:
        self.peak = np.full((designs, levels, 2), np.nan)
        self.complete = np.zeros((designs, levels), dtype=np.int8)
        self.reason = np.full(designs, "", dtype=object)
        self.grid, self.sizes = grid, sizes
        self.backbone = np.full((designs, np.size(sizes), 2), np.nan)
        self.response = np.full((designs, levels, np.size(grid)), np.nan)
        self.converged = np.full((designs, levels, 5), np.nan) if converged else None
        self.state = None
        if elements is not None:
            shape = designs, levels, elements
            self.state = np.full(shape, contact_states.UNKNOWN, dtype=np.int8)

    def add(self, place: int, joint: Joint, branches: Sequence["Branch"]) -> None:
        """Keep what is observed of the responses of a design."""
        for level, branch in enumerate(branches):
            self.complete[place, level] = branch.complete
            if branch.peak is not None:
                at = branch.peak
                self.peak[place, level] = branch.frequency[at], branch.amplitude[at]
                if self.state is not None:
                    motion = ModalContact(joint.contact).motion(branch.modal_coordinate[at])
                    states = joint.law.contact_state(motion, branch.frequency[at])
                    self.state[place, level, : states.size] = states
            if self.grid is not None:
                self.response[place, level] = amplitude_on_grid(
                    branch.frequency, branch.amplitude, self.grid
                )
        self.reason[place] = next((branch.reason for branch in branches if branch.reason), "")

    def add_converged(self, place: int, peaks: Sequence[ConvergedPeak]) -> None:
        """Keep the peaks of a design with all harmonics."""
        self.converged[place] = [(*peak.values, *peak.truncation_error) for peak in peaks]

    def dataset(self) -> xr.Dataset:
        """All of it, by design and force."""
        along = "design", "force"
        why = "why the design is impossible, or a branch ends before or has no peak"
        rows = {
            "peak_frequency": (along, self.peak[..., 0], "Hz", "frequency of the largest maximum"),
            "peak_amplitude": (along, self.peak[..., 1], "m", "largest maximum of the response"),
            "complete": (along, self.complete, "1", "1 where the branch crosses the whole window"),
            "reason": ("design", self.reason.astype(str), "1", why),
        }
        if self.converged is not None:
            for place, (name, unit, meaning) in enumerate(_CONVERGED):
                rows[name] = (along, self.converged[..., place], unit, meaning)
        if self.grid is not None:
            meaning = "first-harmonic amplitude of the output point"
            rows["frequency"] = ("frequency", self.grid, "Hz", "excitation frequency")
            rows["response_amplitude"] = ((*along, "frequency"), self.response, "m", meaning)
        if self.sizes is not None:
            rows["amplitude"] = ("amplitude", self.sizes, "m", "amplitude of the output point")
            of_mode = ("natural_frequency", "Hz"), ("damping_ratio", "1")
            for (name, unit), values in zip(
                of_mode, np.moveaxis(self.backbone, -1, 0), strict=True
            ):
                meaning = f"{name.replace('_', ' ')} of the nonlinear mode"
                rows[name] = (("design", "amplitude"), values, unit, meaning)
        variables = {name: quantity(*row) for name, row in rows.items()}
        if self.state is not None:
            dims = (*along, "element")
            variables["contact_state"] = xr.Variable(dims, self.state, contact_states.ATTRIBUTES)
        return xr.Dataset(variables)
