"""Numbers of the gallery found in a second way: equations of vibration that are written here anew.

Friction under constant load is that of sliders with Coulomb's law, in one harmonic by its closed
form and in several by marching through samples of a period.
"""

from itertools import product

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import norm


def slider_stiffness(amplitude, stiffness, slip_force):
    """Complex stiffness of sliders under harmonic motion, by the closed form."""
    ratio = np.minimum(slip_force / np.maximum(stiffness * amplitude, 1e-300), 1.0)
    angle = np.arccos(1 - 2 * ratio)
    real = stiffness / np.pi * (angle - np.sin(2 * angle) / 2)
    # work of a period over pi times the square of the amplitude
    return real + 1j * 4 / np.pi * stiffness * ratio * (1 - ratio)


class OneHarmonic:
    """A joint under constant load in one harmonic."""

    def __init__(self, joint, loss_factor):
        self.joint = joint
        self.rows = joint.tangential_mode[joint.law.point_of_element]
        self.L = (2 * np.pi * joint.natural_frequency) ** 2
        self.structure = (1 + 1j * loss_factor) * self.L

    def residual(self, x, w, force):
        q = x[: self.L.size] + 1j * x[self.L.size :]
        u = self.rows @ q
        law = self.joint.law
        friction = slider_stiffness(abs(u), law.tangential_stiffness, law.slip_force) * u
        r = (self.structure - w * w) * q + self.rows.T @ friction
        r = (r - force * self.joint.excitation_mode) / (
            force * abs(self.joint.excitation_mode).max()
        )
        return np.concatenate([r.real, r.imag])

    def check_peak(self, response, place):
        """Assert that a peak of a response fulfils the equations, and its neighbours are lower."""
        force, frequency = (float(response[n][place]) for n in ("force_level", "peak_frequency"))
        solved = response["frequency"].where(response["excitation_force"] == force).to_numpy()
        nearest = int(np.nanargmin(abs(solved - frequency)))
        motion = response["modal_coordinate"].isel(solution=nearest)
        start = np.concatenate([motion.sel(component=each).to_numpy() for each in ("sin", "cos")])
        # over the excitation; the solver of the library is content with as much
        assert abs(self.residual(start, 2 * np.pi * solved[nearest], force)).max() < 1e-7
        below, at, above = (
            self._amplitude(start, 2 * np.pi * frequency * (1 + step), force)
            for step in (-1e-4, 0.0, 1e-4)
        )
        assert below < at > above
        np.testing.assert_allclose(at, float(response["peak_amplitude"][place]), rtol=1e-6)

    def _amplitude(self, start, w, force):
        """Amplitude of the output point [m] near another solution, by Newton's method."""
        size, x = abs(start).max(), start
        steps = 1e-6 * size * np.eye(x.size)
        for _ in range(20):
            r = self.residual(x, w, force)
            if abs(r).max() < 1e-10:
                break
            ahead, behind = (
                np.column_stack([self.residual(x + sign * h, w, force) for h in steps])
                for sign in (1, -1)
            )
            x = x - np.linalg.solve((ahead - behind) / (2e-6 * size), r)
        assert abs(r).max() < 1e-10
        return abs(self.joint.response_mode @ (x[: self.L.size] + 1j * x[self.L.size :]))


def opening_contact(amplitude, joint, samples=4000):
    """Mean and complex amplitude of the modal force of a contact that opens as it slips.

    The mode moves by ``bias + amplitude cos(wt)``, and the bias is that of equilibrium.
    """
    law, (R,), (S,) = joint.law, joint.tangential_mode[:, 0], joint.normal_mode[:, 0]
    k, kn, n0, mu = (
        float(getattr(law, name)[0])
        for name in (
            "tangential_stiffness",
            "normal_stiffness",
            "normal_load",
            "friction_coefficient",
        )
    )
    angle = 2 * np.pi * np.arange(samples) / samples

    def force(bias):
        q = bias + amplitude * np.cos(angle)
        n, z, f = np.maximum(n0 + kn * S * q, 0.0), 0.0, np.empty(samples)
        # the second period is periodic
        for _ in range(2):
            for place, (u, limit) in enumerate(zip(R * q, mu * n, strict=True)):
                z = min(max(z, k * u - limit), k * u + limit)
                f[place] = k * u - z
        return R * f + S * (n - max(n0, 0.0))

    w0 = 2 * np.pi * float(joint.natural_frequency[0])
    bias = brentq(lambda b: w0**2 * b + force(b).mean(), -2 * amplitude, 2 * amplitude, rtol=1e-6)
    return 2 * np.mean(force(bias) * np.exp(-1j * angle))


def force_at_peaks(amplitudes, joint, damping_ratio):
    """Least force [N] that moves the mode by each amplitude at some frequency."""
    w0 = 2 * np.pi * float(joint.natural_frequency[0])
    forces = []
    for amplitude in amplitudes:
        friction = opening_contact(amplitude, joint)

        def size(w, a=amplitude, friction=friction):
            return abs((w0**2 - w * w + 2j * damping_ratio * w0 * w) * a + friction)

        stuck = np.sqrt(w0**2 + friction.real / amplitude)
        found = minimize_scalar(size, bounds=(0.9 * stuck, 1.1 * stuck), method="bounded")
        forces.append(found.fun / abs(joint.excitation_mode[0]))
    return np.array(forces)


def total_indices(function, distributions, order):
    """Total Sobol indices by Gauss quadrature of all parameters."""
    # of a normal variable behind each parameter: quantiles of lognormal ones are smooth in it
    node, weight = np.polynomial.hermite_e.hermegauss(order)
    weight = weight / weight.sum()
    points = [each.ppf(norm.cdf(node)) for each in distributions]
    samples = np.array(list(product(*points))).T
    shape = (order,) * len(points)
    values = np.asarray(function(samples)).reshape(shape)
    weights = np.prod(np.meshgrid(*[weight] * len(points), indexing="ij"), axis=0)
    mean = (weights * values).sum()
    variance = (weights * (values - mean) ** 2).sum()
    found = []
    for axis in range(len(points)):
        others = np.tensordot(values, weight, (axis, 0))
        of_others = weights.sum(axis=axis)
        found.append(1 - (of_others * (others - mean) ** 2).sum() / variance)
    return np.array(found)
