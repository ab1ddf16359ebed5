"""The least work a frequency response needs: one compiled loop for one law, nothing else in it.

    python benchmarks/least_work.py JOINT.nc ...

follows the response of joints under constant normal load, loss factor 0.002, through the same
window with the same steps and tolerance as ``solve_branch``: arc length, tangent predictor and
analytic Jacobian, without location of peaks, corners, records or checks, and prints the time of
both and their ratio. Elements that stick cost a comparison: their stiffness is in the linear part.
"""

import argparse
import time
from math import atan2, pi, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from boltjoint.dynamics.frequency_response import solve_branch
from boltjoint.dynamics.windows import frequency_window
from boltjoint.joint.io import load_joint
from boltjoint.joint.model import Joint
from boltjoint.solvers.equations import StepControl

LOSS_FACTOR = 0.002

#: slipping elements whose tangents are projected together
BLOCK = 128
CONTROL = StepControl()

Array = NDArray[np.float64]


@njit(cache=True)
def solve(A: Array, b: Array) -> None:
    """Gaussian elimination with partial pivoting."""
    n = b.size
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
def evaluate(
    R: Array, k: Array, slip: Array, L: Array, e: Array, x: Array, w: float, r: Array, J: Array
) -> None:
    """Residual and Jacobian at once; L is the linear part with sticking contact.

    Tangents of many slipping elements are projected by one product of matrices.
    """
    n, m = x.size, R.shape[1]
    for i in range(n):
        r[i] = -e[i]
        for j in range(n):
            J[i, j] = L[i, j]
            r[i] += L[i, j] * x[j]
        J[i, i] -= w * w
        r[i] -= w * w * x[i]
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
            product = np.dot(left[:count].T, right[:count])
            count = 0
            for i in range(m):
                for j in range(m):
                    J[i, j] += product[i, j]
                    J[i, m + j] += product[i, m + j]
                    J[m + i, j] += product[i, 2 * m + j]
                    J[m + i, m + j] += product[i, 3 * m + j]


@njit(cache=True)
def bordered(J: Array, x: Array, w: float, size: float, scale: float, A: Array) -> None:
    """Jacobian beside the derivative by the frequency, in scaled coordinates."""
    n = x.size
    for i in range(n):
        for j in range(n):
            A[i, j] = J[i, j] * size
        A[i, n] = -2.0 * w * x[i] * scale


@njit(cache=True)
def follow(
    R: Array,
    k: Array,
    slip: Array,
    L: Array,
    e: Array,
    x: Array,
    low: float,
    high: float,
    scales: tuple[float, float],
    limits: tuple[float, float, float, float],
    iterations: tuple[int, int],
    xs: Array,
    ws: Array,
) -> int:
    """Solutions from one end of the window to beyond the other; their number."""
    tolerance, length, longest, shortest = limits
    target, most = iterations
    n = x.size
    r, J, A, b = np.empty(n), np.empty((n, n)), np.empty((n + 1, n + 1)), np.empty(n + 1)
    y, offset, tangent = np.empty(n), np.empty(n + 1), np.zeros(n + 1)
    tolerance *= sqrt((e * e).sum())
    w = low
    while True:
        evaluate(R, k, slip, L, e, x, w, r, J)
        if sqrt((r * r).sum()) <= tolerance:
            break
        size = sqrt((r * r).sum())
        solve(J, r)
        b[:n], damping = r, 1.0
        for _ in range(4):
            evaluate(R, k, slip, L, e, x - damping * b[:n], w, r, J)
            if sqrt((r * r).sum()) < size:
                break
            damping *= 0.5
        x -= damping * b[:n]
    tangent[n] = 1.0
    count = 0
    while True:
        xs[count], ws[count] = x, w
        count += 1
        if w >= high:
            return count
        size, scale = sqrt((x * x).sum()), min(scales[0], scales[1] * w)
        bordered(J, x, w, size, scale, A)
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
                evaluate(R, k, slip, L, e, y, v, r, J)
                sphere = (offset * offset).sum() / length - length
                if sqrt((r * r).sum()) <= tolerance and abs(sphere) <= 1e-3 * length:
                    done = iteration
                    break
                bordered(J, y, v, size, scale, A)
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
        on = joint.law.point_of_element
        self.R = np.ascontiguousarray(joint.tangential_mode[on])
        self.k, self.slip = joint.law.tangential_stiffness, joint.law.slip_force
        squared = np.diag((2 * np.pi * joint.natural_frequency) ** 2)
        stuck, zero = squared + joint.stuck_stiffness(), np.zeros_like(squared)
        damping = LOSS_FACTOR * squared
        self.L = np.block([[stuck, -damping], [damping, stuck]])
        self.e = np.concatenate([force * joint.excitation_mode, zero[0]])
        self.low, self.high = (2 * np.pi * f for f in window)

    def solve(self) -> tuple[Array, Array]:
        """Frequencies [Hz] and unknowns of all solutions."""
        n = self.e.size
        xs, ws = np.empty((CONTROL.maximum_solutions, n)), np.empty(CONTROL.maximum_solutions)
        x = np.linalg.solve(self.L - self.low**2 * np.eye(n), self.e)
        count = follow(
            *(self.R, self.k, self.slip, self.L, self.e, x, self.low, self.high),
            (CONTROL.window_scale * (self.high - self.low), CONTROL.parameter_scale),
            (
                CONTROL.tolerance,
                CONTROL.first_step,
                CONTROL.largest_step,
                CONTROL.smallest_step,
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
    parser.add_argument("joints", nargs="+", help="joint.nc under constant normal load")
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
                    return solve_branch(joint, force, loss_factor=LOSS_FACTOR, window=window)

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
