"""The least work a frequency response needs: one compiled loop for one law, nothing else in it.

    python benchmarks/least_work.py JOINT.nc ...

follows the response of joints, loss factor 0.002, through the same window with the same steps and
tolerance as ``solve_branch``: arc length, tangent predictor and analytic Jacobian, without location
of peaks, corners, records or checks, and prints the time of both and their ratio. Elements that
stick cost a comparison: their stiffness is in the linear part. Elements that do the same as others
are there once.
"""

import argparse
import time
from collections.abc import Callable
from math import atan2, pi, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.friction.contact_states import SEPARATION, STICK, STICK_SLIP
from boltjoint.friction.variable import VariableLoad
from boltjoint.friction.variable_kernels import _find_secants
from boltjoint.joint.io import load_joint
from boltjoint.joint.model import Joint
from boltjoint.solvers.compiled_linear import LARGEST_ELIMINATED
from boltjoint.solvers.newton import ROUNDING
from boltjoint.solvers.step_control import StepControl

LOSS_FACTOR = 0.002

#: slipping elements whose tangents are projected together
BLOCK = 128
CONTROL = StepControl()

Array = NDArray[np.float64]
#: rows of modes along and across the contact, and quantities of the law
Elements = tuple[Array, Array, tuple[Array, Array, Array, Array]]
#: linear part with sticking contact, squares of harmonic numbers, and excitation
Linear = tuple[Array, Array, Array]


@njit(cache=True)
def solve(A: Array, b: Array) -> None:
    """Gaussian elimination with partial pivoting, by LAPACK where that is faster."""
    n = b.size
    if n > LARGEST_ELIMINATED:
        b[:] = np.linalg.solve(A, b)
        return
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(A[i, k]) > abs(A[pivot, k]):
                pivot = i
        if pivot != k:
            for j in range(k, n):
                A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
            b[k], b[pivot] = b[pivot], b[k]
        for i in range(k + 1, n):
            factor = A[i, k] / A[k, k]
            for j in range(k + 1, n):
                A[i, j] -= factor * A[k, j]
            b[i] -= factor * b[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[k] -= A[k, j] * b[j]
        b[k] /= A[k, k]


@njit(cache=True)
def evaluate_linear(L: Array, h: Array, e: Array, x: Array, w: float, r: Array, J: Array) -> None:
    """Residual and Jacobian with sticking contact; h is the square of the harmonic number."""
    for i in range(x.size):
        r[i] = -e[i]
        for j in range(x.size):
            J[i, j] = L[i, j]
            r[i] += L[i, j] * x[j]
        J[i, i] -= h[i] * w * w
        r[i] -= h[i] * w * w * x[i]


@njit(cache=True)
def add_product(left: Array, right: Array, parts: int, J: Array) -> None:
    """Add the tangents of many slipping elements by one product of matrices."""
    product, m = np.dot(left.T, right), left.shape[1]
    for a in range(parts):
        for i in range(m):
            for b in range(parts):
                for j in range(m):
                    J[a * m + i, b * m + j] += product[i, (a * parts + b) * m + j]


@njit(cache=True)
def evaluate_constant(
    elements: Elements, linear: Linear, x: Array, w: float, r: Array, J: Array
) -> None:
    """Residual and Jacobian of elements under constant normal load at once."""
    evaluate_linear(*linear, x, w, r, J)
    R, _, (k, slip, _, _) = elements
    m = R.shape[1]
    left, right = np.empty((BLOCK, m)), np.empty((BLOCK, 4 * m))
    count = 0
    for p in range(k.size):
        s, c = 0.0, 0.0
        for i in range(m):
            s += R[p, i] * x[i]
            c += R[p, i] * x[m + i]
        square = s * s + c * c
        if k[p] * k[p] * square > slip[p] * slip[p]:
            ratio = slip[p] / (k[p] * sqrt(square))
            a, b = sqrt(ratio), sqrt(1.0 - ratio)
            sine, cosine = 2.0 * a * b, 1.0 - 2.0 * ratio
            factor = k[p] / pi
            real = factor * (2.0 * atan2(a, b) - sine * cosine) - k[p]
            imag = 4.0 * factor * ratio * (1.0 - ratio)
            d_real = -4.0 * factor * ratio * sine / square
            d_imag = 4.0 * factor * ratio * (2.0 * ratio - 1.0) / square
            g_s, g_c = d_real * s - d_imag * c, d_real * c + d_imag * s
            f_s, f_c = real * s - imag * c, real * c + imag * s
            ss, sc = real + g_s * s, -imag + g_s * c
            cs, cc = imag + g_c * s, real + g_c * c
            for i in range(m):
                row = R[p, i]
                r[i] += row * f_s
                r[m + i] += row * f_c
                left[count, i] = row
                right[count, i], right[count, m + i] = row * ss, row * sc
                right[count, 2 * m + i], right[count, 3 * m + i] = row * cs, row * cc
            count += 1
        if count == BLOCK or p == k.size - 1:
            add_product(left[:count], right[:count], 2, J)
            count = 0


@njit(cache=True)
def evaluate_variable(
    elements: Elements, linear: Linear, x: Array, w: float, r: Array, J: Array
) -> None:
    """Residual and Jacobian of elements under variable normal load at once.

    Open elements stay in the linear part with their stiffness in stick too, or without.
    """
    evaluate_linear(*linear, x, w, r, J)
    R, N, (k_u, k_v, load, mu) = elements
    m = R.shape[1]
    left, right = np.empty((BLOCK, m)), np.empty((BLOCK, 9 * m))
    normal_left, normal_right = np.empty((BLOCK, m)), np.empty((BLOCK, 9 * m))
    u, v, n = np.empty(3), np.empty(3), np.empty(3)
    events, secants = np.empty((10, 8)), np.empty((3, 3, 3))
    count, normal_count = 0, 0
    for p in range(k_u.size):
        u[:] = v[:] = 0.0
        for i in range(m):
            for a in range(3):
                u[a] += R[p, i] * x[a * m + i]
                v[a] += N[p, i] * x[a * m + i]
        for a in range(3):
            u[a] *= k_u[p]
            v[a] *= k_v[p]
            n[a] = v[a]
        n[0] += load[p]
        amplitude = sqrt(n[1] * n[1] + n[2] * n[2])
        was_closed = load[p] > 0.0
        closed = n[0] > amplitude
        if closed and was_closed:
            lower = sqrt((u[1] - mu[p] * n[1]) ** 2 + (u[2] - mu[p] * n[2]) ** 2)
            upper = sqrt((u[1] + mu[p] * n[1]) ** 2 + (u[2] + mu[p] * n[2]) ** 2)
            reach = mu[p] * n[0]
            if u[0] - reach + lower <= 0.0 and u[0] + reach - upper >= 0.0:
                continue
        elif not was_closed and n[0] <= -amplitude:
            continue
        state = _find_secants(u, n, mu[p], events, secants)
        if state == SEPARATION:
            secants[:] = 0.0
        for a in range(3):
            friction, above = 0.0, -max(load[p], 0.0) if a == 0 else 0.0
            for b in range(3):
                friction += secants[0, a, b] * u[b] + secants[1, a, b] * n[b]
                above += secants[2, a, b] * n[b]
            if was_closed:
                friction -= u[a]
                above -= v[a]
            for i in range(m):
                r[a * m + i] += R[p, i] * friction + N[p, i] * above
        stuck = 1.0 if was_closed else 0.0
        moves = state != STICK and state != STICK_SLIP
        for i in range(m):
            left[count, i] = R[p, i]
            for a in range(3):
                for b in range(3):
                    known = stuck if a == b else 0.0
                    t, of_n = k_u[p] * (secants[0, a, b] - known), k_v[p] * secants[1, a, b]
                    right[count, (3 * a + b) * m + i] = t * R[p, i] + of_n * N[p, i]
            if moves:
                normal_left[normal_count, i] = N[p, i]
                for a in range(3):
                    for b in range(3):
                        t = k_v[p] * (secants[2, a, b] - (stuck if a == b else 0.0))
                        normal_right[normal_count, (3 * a + b) * m + i] = t * N[p, i]
        count += 1
        normal_count += moves
        if count == BLOCK:
            add_product(left, right, 3, J)
            add_product(normal_left[:normal_count], normal_right[:normal_count], 3, J)
            count = normal_count = 0
    add_product(left[:count], right[:count], 3, J)
    add_product(normal_left[:normal_count], normal_right[:normal_count], 3, J)


@njit(cache=True)
def bordered(J: Array, h: Array, x: Array, w: float, size: float, scale: float, A: Array) -> None:
    """Jacobian beside the derivative by the frequency, in scaled coordinates."""
    n = x.size
    for i in range(n):
        for j in range(n):
            A[i, j] = J[i, j] * size
        A[i, n] = -2.0 * w * h[i] * x[i] * scale


@njit(cache=True)
def follow(
    evaluate: Callable,
    elements: Elements,
    linear: Linear,
    x: Array,
    low: float,
    high: float,
    scales: tuple[float, float],
    limits: tuple[float, float, float, float, float],
    iterations: tuple[int, int],
    xs: Array,
    ws: Array,
) -> int:
    """Solutions from one end of the window to beyond the other; their number."""
    tolerance, length, longest, shortest, cosine = limits
    target, most = iterations
    n = x.size
    r, J, A, b = np.empty(n), np.empty((n, n)), np.empty((n + 1, n + 1)), np.empty(n + 1)
    y, offset, tangent = np.empty(n), np.empty(n + 1), np.zeros(n + 1)
    L, h, e = linear
    tolerance *= sqrt((e * e).sum())
    w = low
    while True:
        evaluate(elements, linear, x, w, r, J)
        if sqrt((r * r).sum()) <= tolerance:
            break
        size = sqrt((r * r).sum())
        solve(J, r)
        b[:n], damping = r, 1.0
        for _ in range(4):
            evaluate(elements, linear, x - damping * b[:n], w, r, J)
            if sqrt((r * r).sum()) < size:
                break
            damping *= 0.5
        x -= damping * b[:n]
    tangent[n] = 1.0
    count = 0
    while True:
        xs[count], ws[count] = x, w
        count += 1
        if w >= high or count == ws.size:
            return count if w >= high else -count
        size, scale = sqrt((x * x).sum()), min(scales[0], scales[1] * w)
        terms = np.abs(L) @ np.abs(x)
        near = max(tolerance, ROUNDING * sqrt((terms * terms).sum()))
        bordered(J, h, x, w, size, scale, A)
        for i in range(n):
            A[i] /= sqrt((A[i] * A[i]).sum())
        A[n], b[:] = tangent, 0.0
        if count > 1:  # the last offset, in the new scales
            A[n, :n] /= size
            A[n, n] /= scale
        b[n] = 1.0
        solve(A, b)
        tangent[:] = b / sqrt((b * b).sum())
        while True:
            offset[:] = length * tangent
            done = -1
            for iteration in range(most + 1):
                y[:] = x + size * offset[:n]
                v = w + scale * offset[n]
                evaluate(elements, linear, y, v, r, J)
                sphere = (offset * offset).sum() / length - length
                if sqrt((r * r).sum()) <= near and abs(sphere) <= 1e-3 * length:
                    if (offset * tangent).sum() >= cosine * length:
                        done = iteration
                    break
                bordered(J, h, y, v, size, scale, A)
                A[n], b[:n], b[n] = 2.0 * offset / length, r, sphere
                solve(A, b)
                offset -= b
            if done >= 0 or length < shortest:
                break
            length *= 0.5
        if done < 0:
            return -count
        tangent[:n], tangent[n] = size * offset[:n], scale * offset[n]
        x[:], w = y, v
        length = min(length * min(max((target + 1) / (done + 1), 0.5), 2.0), longest)


class LeastWork:
    """The loop for one joint and force."""

    def __init__(self, joint: Joint, force: float, window: tuple[float, float]) -> None:
        joint = joint.distinct
        law, on = joint.law, joint.law.point_of_element
        balance = HarmonicBalance(joint, LOSS_FACTOR, force)
        static, harmonic, *_ = balance.linear_part()
        self.linear = static + balance.contact.stuck_stiffness, harmonic**2, balance.modal_force
        R = np.ascontiguousarray(joint.tangential_mode[on])
        if isinstance(law, VariableLoad):
            self.evaluate = evaluate_variable
            N = np.ascontiguousarray(joint.normal_mode[on])
            of_law = law.tangential_stiffness, law.normal_stiffness, law.normal_load
            self.elements = R, N, (*of_law, law.friction_coefficient)
        else:
            self.evaluate = evaluate_constant
            none = np.zeros(0)
            self.elements = R, R[:0], (law.tangential_stiffness, law.slip_force, none, none)
        self.low, self.high = (2 * np.pi * f for f in window)

    def solve(self) -> tuple[Array, Array]:
        """Frequencies [Hz] and unknowns of all solutions."""
        L, h, e = self.linear
        xs, ws = np.empty((CONTROL.maximum_solutions, e.size)), np.empty(CONTROL.maximum_solutions)
        x = np.linalg.solve(L - np.diag(h) * self.low**2, e)
        count = follow(
            *(self.evaluate, self.elements, self.linear, x, self.low, self.high),
            (CONTROL.window_scale * (self.high - self.low), CONTROL.parameter_scale),
            (
                CONTROL.tolerance,
                CONTROL.first_step,
                CONTROL.largest_step,
                CONTROL.smallest_step,
                CONTROL.smallest_cosine,
            ),
            (CONTROL.target_iterations, CONTROL.maximum_iterations),
            *(xs, ws),
        )
        if count < 0:
            raise RuntimeError("the path breaks off")
        return ws[:count] / (2 * np.pi), xs[:count]


def median_time(run, repeats: int = 15) -> float:  # noqa: ANN001
    """Median of the processor time of a call [s]."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    return float(np.median(times))


def main() -> None:
    """Print the times of both, and their ratio."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("joints", nargs="+", help="joint.nc")
    parser.add_argument("--forces", nargs="+", type=float, default=[1.0, 10.0, 50.0])
    arguments = parser.parse_args()
    with threadpool_limits(1):
        for path in arguments.joints:
            joint = load_joint(path)
            window = frequency_window(joint)
            for force in arguments.forces:
                least = LeastWork(joint, force, window)
                frequency, _ = least.solve()

                def full(joint=joint, force=force, window=window):  # noqa: ANN001, ANN202
                    return solve_branch(
                        joint, force, damping=LOSS_FACTOR, resonance=Resonance(1, window)
                    )

                branch = full()
                times = median_time(least.solve), median_time(full)
                print(
                    f"{path} {joint.law.slip_force.size} elements, {force:g} N: "
                    f"{frequency.size} and {branch.frequency.size} solutions, "
                    f"{1e3 * times[0]:.2f} and {1e3 * times[1]:.2f} ms, ratio "
                    f"{times[1] / times[0]:.2f}"
                )


if __name__ == "__main__":
    main()
