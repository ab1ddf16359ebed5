"""Damping of the structure: models of the force that opposes its motion, and their parameters.

Under a harmonic motion ``q = Im(z exp(iwt))`` of the modal coordinates the damping force is
``Im(i H(w) z exp(iwt))`` with a real symmetric matrix H, a sum of terms that grow with a power of
the frequency: the power 0 is hysteretic (structural) damping, the power 1 viscous damping
``H = w C``. A harmonic h of a periodic motion has ``H(hw)``.

A model is a class of ``Damping`` among ``MODELS``; configuration, result files and documents follow
from its name and its ``quantities``.

References
----------
M. Géradin, D. J. Rixen: Mechanical Vibrations: Theory and Application to Structural Dynamics.
Third edition, Wiley (2015).
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ModalStructure:
    """The structure without contact in the coordinates of a balance, as damping models need it.

    Parameters
    ----------
    frequency
        w_r of the vectors of the modal basis [rad/s], shape (vectors,).
    basis
        V, orthonormal combinations of these vectors, shape (vectors, modes); the vectors themselves
        by default.
    free_frequency
        w_r of the modes without contact [rad/s], shape (free modes,), where the vectors are others.
    free_participation
        ``phi_r^T M`` of these modes times the vectors [-], shape (free modes, vectors).
    """

    frequency: Array
    basis: Array | None = None
    free_frequency: Array | None = None
    free_participation: Array | None = None

    @cached_property
    def mass(self) -> Array:
        """The unit matrix: bases are orthonormal in mass [-], shape (modes, modes)."""
        return np.eye(self.frequency.size if self.basis is None else self.basis.shape[1])

    @cached_property
    def stiffness(self) -> Array:
        """``V^T diag(w_r^2) V`` [rad^2/s^2], shape (modes, modes)."""
        return self.of_vectors(self.frequency**2)

    def of_vectors(self, value: Array) -> Array:
        """``V^T diag(value) V`` of a value of each vector of the basis, shape (modes, modes)."""
        diagonal = np.diag(value)
        return diagonal if self.basis is None else self.basis.T @ diagonal @ self.basis

    def stiffness_to_hold(self, vectors: NDArray[np.bool_]) -> Array:
        """A stiffness of some vectors as high as the highest, shape (modes, modes)."""
        return self.of_vectors(vectors * self.frequency.max() ** 2)

    @cached_property
    def free_modes(self) -> tuple[Array, Array]:
        """w_r of modes without contact [rad/s], and ``phi_r^T M V``, shape (free modes, modes)."""
        w, P = self.free_frequency, self.free_participation
        if w is None or P is None:
            w, P = self.frequency, np.eye(self.frequency.size)
        return w, P if self.basis is None else P @ self.basis


class Term(NamedTuple):
    """A term ``factor w^power matrix`` of H(w) [rad^2/s^2]; the power is not negative."""

    power: float
    factor: float
    matrix: Array


class DampingMatrix:
    """H(w) of a structure as a sum of terms.

    Parameters
    ----------
    terms
        Terms of H.
    """

    def __init__(self, terms: Iterable[Term]) -> None:
        self.terms = tuple(terms)

    @property
    def dissipates(self) -> bool:
        """Whether any motion is damped."""
        return any(term.factor != 0 and term.matrix.any() for term in self.terms)

    @cached_property
    def constant(self) -> "DampingMatrix":
        """The terms that do not depend on the frequency."""
        return DampingMatrix(term for term in self.terms if term.power == 0)

    @cached_property
    def varying(self) -> "DampingMatrix | None":
        """The terms that depend on the frequency; None without any."""
        terms = [term for term in self.terms if term.power != 0]
        return DampingMatrix(terms) if terms else None

    def at(self, w: float) -> Array | float:
        """H at a frequency [rad/s], shape (modes, modes); 0 without terms."""
        return sum(factor * w**power * matrix for power, factor, matrix in self.terms)

    @cached_property
    def derivative(self) -> "DampingMatrix":
        """Derivative of H by the frequency."""
        return DampingMatrix(
            Term(power - 1, power * factor, matrix)
            for power, factor, matrix in self.terms
            if power != 0
        )

    def along(self, motion: Array, w: Array | float) -> Array:
        """``H(w) x`` of motions x, at a frequency [rad/s] or one of each, shape (motions, modes).

        Frequencies of each have the shape (motions, 1).
        """
        forces = (factor * w**power * (motion @ H.T) for power, factor, H in self.terms)
        return sum(forces, np.zeros_like(motion))

    def work(self, w: float, s: Array, c: Array) -> float:
        """``s^T H s + c^T H c``, the energy lost in a period over pi [J]."""
        return sum(
            factor * w**power * (s @ matrix @ s + c @ matrix @ c)
            for power, factor, matrix in self.terms
        )


class Damping(ABC):
    """A damping model: a frozen dataclass whose fields are its parameters."""

    #: in the configuration and in result files
    name: ClassVar[str]
    #: by parameter, its unit and meaning
    quantities: ClassVar[Mapping[str, tuple[str, str]]]

    @abstractmethod
    def terms(self, structure: ModalStructure) -> tuple[Term, ...]:
        """Terms of H(w) in the coordinates of a structure."""

    def matrix(self, structure: ModalStructure) -> DampingMatrix:
        """H(w) in the coordinates of a structure."""
        return DampingMatrix(self.terms(structure))

    def attributes(self) -> dict[str, Any]:
        """Name and parameters, as a result file holds them."""
        return {"damping": self.name} | {name: getattr(self, name) for name in self.quantities}


@dataclass(frozen=True)
class LossFactor(Damping):
    """Hysteretic damping ``H = eta L``: the same loss factor for all motion, at any frequency."""

    name: ClassVar[str] = "loss_factor"
    quantities: ClassVar[Mapping[str, tuple[str, str]]] = {
        "loss_factor": ("1", "loss factor eta of all modes at every frequency")
    }

    loss_factor: float

    def __post_init__(self) -> None:
        """Refuse a negative loss factor."""
        loss_factor = checks.number("loss_factor", self.loss_factor, at_least=0)
        object.__setattr__(self, "loss_factor", loss_factor)

    def terms(self, structure: ModalStructure) -> tuple[Term, ...]:
        """``eta L``."""
        return (Term(0, self.loss_factor, structure.stiffness),)


@dataclass(frozen=True)
class ModalDamping(Damping):
    """Viscous damping ``C = diag(2 zeta_r w_r)`` of the modes without contact.

    Where the basis has other vectors, each mode with a ratio of its own is damped by its share in
    them, and the last ratio is that of the vectors. Ratios count from the first elastic mode:
    rigid-body modes, at 0 Hz, have none.
    """

    name: ClassVar[str] = "modal"
    quantities: ClassVar[Mapping[str, tuple[str, str]]] = {
        "damping_ratios": (
            "1",
            "damping ratio zeta of each mode without contact, from the first; the last one holds "
            "for all further modes",
        )
    }

    damping_ratios: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse negative ratios; one number stands for all modes."""
        ratios = np.atleast_1d(checks.array("damping_ratios", self.damping_ratios, at_least=0))
        if ratios.ndim > 1 or not ratios.size:
            raise ValueError("damping_ratios must be a number or a list of at least one")
        object.__setattr__(self, "damping_ratios", tuple(ratios.tolist()))

    def terms(self, structure: ModalStructure) -> tuple[Term, ...]:
        """``w diag(2 zeta_r w_r)``."""
        *first, last = self.damping_ratios
        w, P = (part[structure.free_modes[0] > 0] for part in structure.free_modes)
        if len(first) > w.size and structure.free_participation is not None:
            raise ValueError(
                f"damping_ratios holds {len(first) + 1} ratios, but the basis knows {w.size} modes "
                "without contact: give fewer, or more contact_adapted_basis.free_modes"
            )
        count = min(len(first), w.size)
        beyond = 2 * (np.array(first[:count]) - last) * w[:count]
        matrix = structure.of_vectors(2 * last * structure.frequency)
        matrix += P[:count].T @ (beyond[:, None] * P[:count])
        return (Term(1, 1.0, matrix),)


@dataclass(frozen=True)
class RayleighDamping(Damping):
    """Viscous damping ``C = alpha M + beta K``, proportional to mass and stiffness."""

    name: ClassVar[str] = "rayleigh"
    quantities: ClassVar[Mapping[str, tuple[str, str]]] = {
        "mass_coefficient": ("1/s", "coefficient alpha of the mass"),
        "stiffness_coefficient": ("s", "coefficient beta of the stiffness without contact"),
    }

    mass_coefficient: float
    stiffness_coefficient: float

    def __post_init__(self) -> None:
        """Refuse negative coefficients."""
        for name in self.quantities:
            value = checks.number(name, getattr(self, name), at_least=0)
            object.__setattr__(self, name, value)

    def terms(self, structure: ModalStructure) -> tuple[Term, ...]:
        """``w (alpha + beta L)``."""
        return (
            Term(1, self.mass_coefficient, structure.mass),
            Term(1, self.stiffness_coefficient, structure.stiffness),
        )


#: the models by their name
MODELS: Mapping[str, type[Damping]] = {
    model.name: model for model in (LossFactor, ModalDamping, RayleighDamping)
}


def as_damping(damping: Damping | float) -> Damping:
    """The model itself; a number is a loss factor."""
    return damping if isinstance(damping, Damping) else LossFactor(damping)


def make_damping(model: str, **parameters: Any) -> Damping:  # noqa: ANN401
    """The model of a name with its parameters."""
    return MODELS[checks.choice("damping", model, MODELS)](**parameters)


def damping_of_attributes(attributes: Mapping[str, Any]) -> Damping:
    """The model that a result file holds."""
    name = checks.choice("damping", attributes.get("damping", LossFactor.name), MODELS)
    quantities = {quantity: attributes[quantity] for quantity in MODELS[name].quantities}
    return make_damping(name, **quantities)
