"""Settings of a study: the cases that run, and the numerical options."""

from typing import Annotated, Literal

from pydantic import Field

from boltjoint.config.contact_adapted_basis import ContactAdaptedBasis
from boltjoint.config.convergence import Convergence
from boltjoint.config.entries import Entry
from boltjoint.config.fitting import Fitting
from boltjoint.config.hyper_reduction import HyperReduction
from boltjoint.config.solver import Solver
from boltjoint.config.timing import Timing
from boltjoint.config.types import CaseName, Distinct, Name, Problems, Several


class Settings(Entry):
    """The file ``config.yaml``: the cases that run, and the numerical options."""

    cases: Several[CaseName]
    """Cases that run: files of ``cases/`` without ``.yaml``."""
    sweeps: Distinct[tuple[Name, ...]] = ()
    """Sweeps over many designs that run: files of ``sweeps/`` without ``.yaml``."""
    assemblies: Distinct[tuple[Name, ...]] = ()
    """Assemblies to build and tabulate even if no case uses them: files of ``assemblies/``."""
    omit: Distinct[tuple[Literal["timing", "checks", "harmonics"], ...]] = ()
    """Parts to leave out: solution times and costs of models; residuals in time; time integration
    and further harmonics at ``verification_forces_N``."""
    converged_peaks: Annotated[bool, Field(strict=True)] = False
    """Whether each response also has its peaks with as many harmonics as change them by less than
    ``solver.harmonic_tolerance``, and error bars from them: seconds to minutes for each joint."""
    contact_adapted_basis: ContactAdaptedBasis = ContactAdaptedBasis()
    solver: Solver = Solver()
    fitting: Fitting = Fitting()
    hyper_reduction: HyperReduction = HyperReduction()
    timing: Timing = Timing()
    convergence: Convergence = Convergence()

    @property
    def harmonic_convergence(self) -> dict[str, float] | None:
        """Options of ``HarmonicConvergence``; None where peaks are not converged."""
        needed = self.converged_peaks or self.solver.harmonics == "auto"
        return self.solver.harmonic_convergence if needed else None

    def conflicts(self) -> Problems:
        if self.solver.harmonics == "auto":
            if self.sweeps:
                yield ("sweeps",), "must be empty with solver.harmonics: auto"
            if "timing" not in self.omit:
                yield ("omit",), "must hold timing with solver.harmonics: auto"
