"""In which coordinates is the balance solved? Linear modes, or modes that depend on the response.

Every kind of coordinates poses the equations that ``solvers`` follow, and translates its unknown
back into the linear modes of the structure.
"""

from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from boltjoint import checks
from boltjoint.balance import HarmonicBalance
from boltjoint.names import parse_coordinates
from boltjoint.solvers.equations import Equations, LazyJacobian
from boltjoint.solvers.lagged_basis import LaggedEquations

Jacobian = Literal["analytic", "forward-difference"]
Renewal = Literal["within", "after"]

#: forward differences step by this share of the unknown's size: the square root of rounding
_DIFFERENCE = float(np.sqrt(np.finfo(float).eps))


class LinearModes(Equations):
    """The modes of the structure without contact, all of them (MSM, section 2.1.2).

    Parameters
    ----------
    balance
        The modal equations.
    jacobian
        ``analytic``, or ``forward-difference`` as in eq. 2.38.

    Raises
    ------
    ValueError
        If the way to the Jacobian is not known.
    """

    def __init__(self, balance: HarmonicBalance, jacobian: Jacobian = "analytic") -> None:
        checks.instance("balance", balance, HarmonicBalance)
        checks.choice("jacobian", jacobian, get_args(Jacobian))
        self.balance = balance
        self.residual_scale = float(np.linalg.norm(balance.modal_force))
        self._analytic = jacobian == "analytic"
        #: of the excitation that acts
        self.share = 1.0

    def evaluate(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual at the frequency p [rad/s], and what forms its Jacobian."""
        if self._analytic:
            residual, jacobian = self.balance.residual_and_jacobian(x, p)
        else:
            residual, jacobian = self._with_differences(x, p)
        return residual + (1 - self.share) * self.balance.modal_force, jacobian

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the frequency."""
        return self.balance.frequency_derivative(x, p)

    def share_derivative(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivative of the residual by the share of the excitation that acts."""
        return -self.balance.modal_force

    def _residual(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Of the whole excitation."""
        return self.balance.residual(x, p)

    def _with_differences(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        residual = self._residual(x, p)

        def jacobian() -> NDArray[np.float64]:
            columns = np.empty((x.size, x.size))
            size = np.linalg.norm(x) / np.sqrt(x.size) or 1.0
            for j in range(x.size):
                step = _DIFFERENCE * max(abs(x[j]), size)
                moved = x.copy()
                moved[j] += step
                columns[:, j] = (self._residual(moved, p) - residual) / (moved[j] - x[j])
            return columns

        return residual, jacobian


class ResponseDependentModes(LinearModes, LaggedEquations):
    """A few modes of the structure as the contact's present stiffness makes it (RDNM, 2.1.3).

    The modes are eigenvectors of ``L + R^T Re(D) R`` (dual-space form, eq. 2.13 and 2.14), D the
    describing function of each contact point at the last solution. They are renewed after every
    accepted solution and followed by their shape. The equations are projected onto them.

    Parameters
    ----------
    balance
        The modal equations.
    count
        Number of modes kept.
    target
        The mode of the stuck structure that must be among them, from 0.
    jacobian
        As for ``LinearModes``.

    Raises
    ------
    ValueError
        If more modes are asked for than the structure has.
    """

    predictive = implicit = False
    full = None

    def __init__(
        self,
        balance: HarmonicBalance,
        count: int,
        target: int = 0,
        jacobian: Jacobian = "analytic",
    ) -> None:
        super().__init__(balance, jacobian)
        self._linear = balance
        self.basis = _stuck_modes(balance, count, target)[1]

    @property
    def basis(self) -> NDArray[np.float64]:
        """The modes that the unknown stands for, combined from the linear ones."""
        return self.balance.basis

    @basis.setter
    def basis(self, basis: NDArray[np.float64]) -> None:
        self.balance = self.balance.in_basis(basis)

    def update(self, q: NDArray[np.float64], p: float) -> None:
        """New modes from the describing function at amplitudes of the linear modes."""
        matrix = self._linear.stiffness_with(self._linear.secant_stiffness(q).real)
        vectors = np.linalg.eigh(matrix)[1]
        vectors = vectors[:, _like(vectors, self.basis)]
        self.basis = vectors * _signs(vectors, self.basis)

    def from_fixed(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Project amplitudes of the linear modes onto the present modes."""
        return (q.reshape(-1, len(self.basis)) @ self.basis).ravel()

    def to_fixed(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The unknown as amplitude of the linear modes, components one after another."""
        return (x.reshape(-1, self.basis.shape[1]) @ self.basis.T).ravel()

    change_from_fixed, change_to_fixed = from_fixed, to_fixed


class MovingModes(LinearModes):
    """The same modes, of the describing function at the solution itself, not at the one before it.

    The unknown stays the amplitude q of all linear modes. With P = V V^T, V the modes that q makes,
    g the left side of the balance and k a stiffness that makes the units agree, every component
    obeys::

        P g + k (I - P) q = 0

    q lies in the span of its own modes, and the balance holds in them. The derivative knows that
    the modes move with q: with ``A v_i = a_i v_i``,
    ``dv_i = sum over the modes left out, (v_j . dA v_i) / (a_i - a_j) v_j``.

    Parameters
    ----------
    balance, count, target
        As for ``ResponseDependentModes``.

    Raises
    ------
    ValueError
        If more modes are asked for than the structure has.
    """

    def __init__(self, balance: HarmonicBalance, count: int, target: int = 0) -> None:
        super().__init__(balance)
        squared, self._modes = _stuck_modes(balance, count, target)
        self._scale = squared[-1]
        #: where the modes were asked for last, what they continue, and what they are
        self._found: tuple[NDArray[np.float64], ...] | None = None

    @property
    def tracked(self) -> NDArray[np.float64]:
        """The modes at the last solution, by which those at the next are known again."""
        return self._modes

    @tracked.setter
    def tracked(self, modes: NDArray[np.float64]) -> None:
        self._modes = modes

    def evaluate(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual at the frequency p [rad/s], and what forms its Jacobian."""
        motion = self.balance.motion(x)
        force, tangent = self.balance.joint.law.evaluate_with_tangent(motion)
        secant = self.balance.secants(motion, force)
        squared, vectors, kept = self._modes_of(secant.real)
        V, k = vectors[:, kept], self._scale
        self._found = x, self._modes, V
        residual, jacobian_in_all = self.balance.with_contact(x, p, force, tangent)
        residual += (1 - self.share) * self.balance.modal_force
        h = (residual - k * x).reshape(-1, len(V))

        def jacobian() -> NDArray[np.float64]:
            others = np.delete(vectors, kept, axis=1)
            gaps = squared[kept] - np.delete(squared, kept)[:, None]
            # what turns each mode towards those left out, by q: (modes, components * modes)
            change = self.balance.secant_derivative(motion, secant, tangent).real
            turns = [
                others @ (others.T @ self.balance.weighted_products(v, change) / gap[:, None])
                for v, gap in zip(V.T, gaps.T, strict=True)
            ]
            found = jacobian_in_all() - k * np.eye(x.size)
            for part, of_part in zip(found.reshape(*h.shape, -1), h, strict=True):
                part[:] = V @ (V.T @ part)
                for v, turn in zip(V.T, turns, strict=True):
                    part += turn * (v @ of_part) + np.outer(v, of_part @ turn)
            return found + k * np.eye(x.size)

        return (h @ V @ V.T).ravel() + k * x, jacobian

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the frequency."""
        return self._projected(x, super().parameter_derivative(x, p))

    def share_derivative(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivative of the residual by the share of the excitation that acts."""
        return -self._projected(x, self.balance.modal_force)

    def accept(self, x: NDArray[np.float64]) -> None:
        """Remember the modes at x."""
        self._modes = self._modes_at(x)

    def _projected(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        V = self._modes_at(x)
        return (y.reshape(-1, len(V)) @ V @ V.T).ravel()

    def _modes_at(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        if self._found is None or self._found[0] is not x or self._found[1] is not self._modes:
            _, vectors, kept = self._modes_of(self.balance.secant_stiffness(x).real)
            self._found = x, self._modes, vectors[:, kept]
        return self._found[2]

    def _modes_of(
        self, secant: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
        """Squared frequencies and modes, and which of them continue the last ones in shape."""
        squared, vectors = np.linalg.eigh(self.balance.stiffness_with(secant))
        kept = _like(vectors, self._modes)
        vectors[:, kept] *= _signs(vectors[:, kept], self._modes)
        return squared, vectors, kept


class Loading(Equations):
    """The equations of linear modes, or modes of the solution, while the excitation grows.

    The parameter is the logarithm of the share of the excitation that acts, at one frequency.

    Parameters
    ----------
    equations
        Those whose share is varied.
    w
        The frequency [rad/s].
    """

    def __init__(self, equations: LinearModes, w: float) -> None:
        self._equations, self._w = equations, w
        self.residual_scale = equations.residual_scale

    @property
    def tracked(self) -> object:
        """As of the equations."""
        return self._equations.tracked

    @tracked.setter
    def tracked(self, tracked: object) -> None:
        self._equations.tracked = tracked

    def evaluate(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual under exp(p) of the excitation, and what forms its Jacobian."""
        self._equations.share = np.exp(p)
        found = self._equations.evaluate(x, self._w)
        self._equations.share = 1.0
        return found

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the logarithm of the share."""
        return np.exp(p) * self._equations.share_derivative(x)

    def accept(self, x: NDArray[np.float64]) -> None:
        """As of the equations."""
        self._equations.accept(x)


class ComplexModes(LinearModes, LaggedEquations):
    """A few complex modes of the structure as the contact's present force makes it.

    Eigenvectors of the complex symmetric ``A = L (1 + i eta) + R^T D R``, D the complex describing
    function of each contact point, so that they hold what the contact dissipates. They are
    normalised by ``phi^T phi = 1`` and the equations are projected with ``phi^T``, no conjugate, by
    which the modes of a complex symmetric matrix are orthogonal. After every accepted solution they
    are renewed at the point that is expected next, and followed by their shape: so what they lag
    behind is of second order in the step.

    With ``q = Im((s + i c) exp(iwt))``, the unknown is y of ``s + i c = Phi y + q_rest``, its real
    and then its imaginary part, after the bias in all linear modes where the law has one. q_rest is
    what the modes left out add when they see the excitation alone, at the last frequency.

    Parameters
    ----------
    balance
        The modal equations, of one harmonic.
    count, target, jacobian
        As for ``ResponseDependentModes``.
    renewal
        Whether a solution is sought again, in modes renewed where it was found, until they belong
        to it (``within``), or the modes are renewed once for each solution (``after``).
    static_share
        Whether q_rest is added, else it is zero.

    Raises
    ------
    ValueError
        If more modes are asked for than the structure has, or the motion has further harmonics.
    """

    predictive = True

    def __init__(
        self,
        balance: HarmonicBalance,
        count: int,
        target: int = 0,
        jacobian: Jacobian = "analytic",
        renewal: Renewal = "within",
        static_share: bool = True,
    ) -> None:
        super().__init__(balance, jacobian)
        checks.choice("renewal", renewal, get_args(Renewal))
        static_share = checks.flag("static_share", static_share)
        self.implicit = renewal == "within"
        # with all others added, a basis of the solution itself is as good as the linear modes
        exact = self.implicit and static_share
        self.full = LinearModes(balance, jacobian) if exact else None
        if balance.components[-2:] != ("sin", "cos") or len(balance.components) > 3:
            raise ValueError("complex response-dependent modes need a motion of one harmonic")
        self._modes = len(balance.stiffness)
        self._bias = self._modes * (balance.components[0] == "bias")
        self._excitation = balance.joint.excitation_mode * balance.excitation_force
        self._lossy = balance.stiffness * (1 + 1j * balance.loss_factor)
        self._static_share = static_share
        real = _stuck_modes(balance, count, target)[1]
        self.basis = real.astype(complex), np.zeros(self._modes, dtype=complex)

    @property
    def basis(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Phi, shape (linear modes, modes), and q_rest, shape (linear modes,)."""
        return self._phi, self._rest

    @basis.setter
    def basis(self, basis: tuple[NDArray[np.complex128], NDArray[np.complex128]]) -> None:
        self._phi, self._rest = phi, rest = basis
        rows, bias = self.balance.rows, self._bias
        shape = self.balance.joint.points, len(rows), len(self.balance.components)
        size = bias + 2 * phi.shape[1]
        # motion of the points: by the unknown, and at rest; modal forces by those of the points
        self._to_points, self._from_points = np.zeros((2, *shape, size))
        self._points_at_zero = np.zeros(shape)
        for d, B in enumerate(rows):
            Z, at_zero = B @ phi, B @ rest
            self._to_points[:, d, 0, :bias] = self._from_points[:, d, 0, :bias] = B[:, :bias]
            self._to_points[:, d, -2, bias:] = np.hstack([Z.real, -Z.imag])
            self._to_points[:, d, -1, bias:] = np.hstack([Z.imag, Z.real])
            self._from_points[:, d, -2, bias:] = np.hstack([Z.real, Z.imag])
            self._from_points[:, d, -1, bias:] = np.hstack([-Z.imag, Z.real])
            self._points_at_zero[:, d, -2:] = np.column_stack([at_zero.real, at_zero.imag])

    def evaluate(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual at the frequency p [rad/s], and what forms its Jacobian."""
        if not self._analytic:
            return self._with_differences(x, p)
        force, tangent = self.balance.joint.law.evaluate_with_tangent(self._motion(x))
        return self._balanced(x, p, force), lambda: self._jacobian(p, tangent)

    def _jacobian(self, p: float, tangent: NDArray[np.float64]) -> NDArray[np.float64]:
        """The Jacobian from the tangents of the points."""
        phi, bias = self._phi, self._bias
        dynamic = phi.T @ (self._lossy - p**2 * np.eye(len(phi))) @ phi
        jacobian = self._contact_jacobian(tangent)
        jacobian[:bias, :bias] += self.balance.stiffness[:bias, :bias]
        jacobian[bias:, bias:] += np.block(
            [[dynamic.real, -dynamic.imag], [dynamic.imag, dynamic.real]]
        )
        return jacobian

    def _contact_jacobian(self, tangent: NDArray[np.float64]) -> NDArray[np.float64]:
        """What the contact adds to the Jacobian, bias and harmonics apart."""
        points, size = len(tangent), self._to_points.shape[-1]
        forth, back = (of.reshape(points, -1, size) for of in (self._to_points, self._from_points))
        changes = tangent.reshape(points, forth.shape[1], -1) @ forth
        return np.tensordot(back, changes, ([0, 1], [0, 1]))

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the frequency."""
        _, y = self._parts(x)
        derivative = -2.0 * p * (self._phi.T @ (self._phi @ y + self._rest))
        return np.concatenate([np.zeros(self._bias), derivative.real, derivative.imag])

    def update(self, q: NDArray[np.float64], p: float) -> None:
        """New modes from the describing function at amplitudes of the linear modes."""
        secant = self.balance.secant_stiffness(q)
        matrix = self.balance.stiffness_with(secant) + 1j * self._lossy.imag
        squared, vectors = np.linalg.eig(matrix)
        vectors /= np.sqrt(np.sum(vectors * vectors, axis=0))
        kept = _like(vectors, self._phi)
        rest = np.zeros_like(self._rest)
        if self._static_share:
            others = np.delete(vectors, kept, axis=1)
            share = others.T @ self._excitation / (np.delete(squared, kept) - p**2)
            rest = others @ share
        self.basis = vectors[:, kept] * _signs(vectors[:, kept], self._phi), rest

    def from_fixed(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Project amplitudes of the linear modes onto the present modes."""
        return self._from_fixed(q, self._rest)

    def to_fixed(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The unknown as amplitude of the linear modes, components one after another."""
        return self._to_fixed(x, self._rest)

    def change_from_fixed(self, dq: NDArray[np.float64]) -> NDArray[np.float64]:
        """A change of the linear modes' amplitudes as one of the unknown."""
        return self._from_fixed(dq, 0.0)

    def change_to_fixed(self, dx: NDArray[np.float64]) -> NDArray[np.float64]:
        """A change of the unknown as one of the linear modes' amplitudes."""
        return self._to_fixed(dx, 0.0)

    def _from_fixed(
        self, q: NDArray[np.float64], rest: NDArray[np.complex128] | float
    ) -> NDArray[np.float64]:
        bias, (s, c) = q[: self._bias], q[self._bias :].reshape(2, -1)
        y = self._phi.T @ (s + 1j * c - rest)
        return np.concatenate([bias, y.real, y.imag])

    def _to_fixed(
        self, x: NDArray[np.float64], rest: NDArray[np.complex128] | float
    ) -> NDArray[np.float64]:
        bias, y = self._parts(x)
        q = self._phi @ y + rest
        return np.concatenate([bias, q.real, q.imag])

    def _parts(self, x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
        """The bias in linear modes, empty without one, and the amplitudes of the complex modes."""
        real, imaginary = x[self._bias :].reshape(2, -1)
        return x[: self._bias], real + 1j * imaginary

    def _motion(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        motion = self._to_points @ x + self._points_at_zero
        return motion.reshape(len(motion), -1)

    def _residual(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        return self._balanced(x, p, self.balance.joint.law.evaluate(self._motion(x)))

    def _balanced(
        self, x: NDArray[np.float64], p: float, force: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """What is left of the equations when the contact has this force on its points."""
        bias, y = self._parts(x)
        q = self._phi @ y + self._rest
        left = self._phi.T @ (self._lossy @ q - p**2 * q - self._excitation)
        static = self.balance.stiffness @ bias if bias.size else bias
        contact = force.ravel() @ self._from_points.reshape(force.size, -1)
        return np.concatenate([static, left.real, left.imag]) + contact


def pose(
    name: str,
    balance: HarmonicBalance,
    resonance: int,
    jacobian: Jacobian = "analytic",
    renewal: Renewal = "within",
    static_share: bool = True,
) -> LinearModes:
    """Pose the balance in coordinates by their name: ``linear``, ``rdnm-N``, ``complex-rdnm-N``.

    Parameters
    ----------
    name
        The coordinates.
    balance
        The modal equations.
    resonance
        The resonance that is followed, from 1.
    jacobian
        As for ``LinearModes``.
    renewal
        Whether the modes of ``rdnm-N`` are those of the solution itself (``within``), or stay those
        of the last one (``after``). Forward differences, as the source takes them, know the latter
        only. As for ``ComplexModes`` for ``complex-rdnm-N``.
    static_share
        Of the modes left out, as for ``ComplexModes``.

    Raises
    ------
    ValueError
        If the balance cannot be posed in such coordinates, there are not as many modes, or an
        option is not known.
    """
    kind, count = parse_coordinates(name)
    checks.instance("balance", balance, HarmonicBalance)
    target = balance.joint.check_resonance(resonance) - 1
    check_options(jacobian, renewal, static_share)
    if kind == "linear":
        return LinearModes(balance, jacobian)
    if kind == "complex":
        return ComplexModes(balance, count, target, jacobian, renewal, static_share)
    if kind == "real" and renewal == "within" and jacobian == "analytic":
        return MovingModes(balance, count, target)
    if kind == "real":
        return ResponseDependentModes(balance, count, target, jacobian)
    raise ValueError(f"the balance is not posed in {name}")


def check_options(jacobian: Jacobian, renewal: Renewal, static_share: bool) -> None:
    """Refuse options of coordinates that are not known, whichever coordinates have a use for them.

    Parameters
    ----------
    jacobian, renewal, static_share
        As for ``pose``.
    """
    checks.choice("jacobian", jacobian, get_args(Jacobian))
    checks.choice("renewal", renewal, get_args(Renewal))
    checks.flag("static_share", static_share)


def _stuck_modes(
    balance: HarmonicBalance, count: int, target: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Squared frequencies and modes while nothing slips: the target and those next below it."""
    modes = len(balance.stiffness)
    checks.whole("target", target, at_least=0, below=modes)
    if not 1 <= checks.whole("count", count) <= modes:
        raise ValueError(f"{count} response-dependent modes of {modes} linear ones")
    first = max(0, target + 1 - count)
    squared, vectors = np.linalg.eigh(balance.stiffness + balance.joint.stuck_stiffness())
    return squared[first : first + count], vectors[:, first : first + count]


def _like(vectors: NDArray, previous: NDArray) -> NDArray[np.int64]:
    """Which columns best continue each of the previous ones in shape, whatever their length."""
    likeness = np.abs(previous.conj().T @ vectors) / np.linalg.norm(vectors, axis=0)
    return linear_sum_assignment(-likeness)[1]


def _signs(vectors: NDArray, previous: NDArray) -> NDArray[np.float64]:
    """+1 or -1 for each column, to make it continue the previous one."""
    return np.where(np.sum(previous * vectors, axis=0).real < 0, -1.0, 1.0)
