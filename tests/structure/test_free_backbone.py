"""The backbone of a half lap that nothing holds, against all unknowns of its mesh."""

import numpy as np
import pytest
from examples import freed
from scipy.sparse import diags_array
from scipy.sparse.linalg import eigsh, splu

from boltjoint.config.numerical_options import ContactAdaptedBasis
from boltjoint.dynamics.backbone.backbone import find_backbone
from boltjoint.dynamics.reduction.basis_from_backbones import find_pod_modes
from boltjoint.dynamics.reduction.contact_condition import ContactCondition
from boltjoint.dynamics.response.windows import frequency_window
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

STIFFNESS, FRICTION, LOSS_FACTOR = 3e7, 0.1, 2e-3


class WholeStructure:
    """Complex modes of the mesh with its sliders, one by one by inverse iteration."""

    def __init__(self, structure, normal_load):
        moving, pressed = structure.moving, normal_load > 0
        self.K, self.M = (
            matrix[moving][:, moving].tocsc() for matrix in (structure.stiffness, structure.mass)
        )
        self.B = structure.contact.relative[0::3][pressed][:, moving]
        self.limit = FRICTION * normal_load[pressed]
        stuck = (self.K + STIFFNESS * self.B.T @ self.B).tocsc()
        start = np.ones(stuck.shape[0])
        # six of them are rigid
        self.squared, vectors = eigsh(stuck, 7, self.M, sigma=-1e4, v0=start)
        self.first = vectors[:, np.argmax(self.squared)]

    def describing_function(self, u):
        """Of sliders with an amplitude of their displacement."""
        D = np.full(u.shape, STIFFNESS, complex)
        slips = u * STIFFNESS > self.limit
        u, limit = u[slips], self.limit[slips]
        angle = np.arccos(1 - 2 * limit / (STIFFNESS * u))
        D[slips] = STIFFNESS / np.pi * (angle - np.sin(2 * angle) / 2)
        # the energy of a period is 4 limit (u - limit / k)
        D[slips] += 4j * limit * (u - limit / STIFFNESS) / (np.pi * u**2)
        return D

    def mode(self, amplitude, near):
        """Complex eigenvalue of the first elastic mode at a modal amplitude, near a value."""
        x = self.first.astype(complex)
        for _ in range(200):
            D = diags_array(self.describing_function(amplitude * abs(self.B @ x)))
            A = (self.K * (1 + 1j * LOSS_FACTOR) + self.B.T @ D @ self.B).tocsc()
            factors = splu((A - 1.001 * near * self.M).tocsc())
            y = factors.solve(self.M @ factors.solve(self.M @ x))
            y *= np.exp(-1j * np.angle(np.vdot(x, self.M @ y)))
            y /= np.sqrt(np.vdot(y, self.M @ y).real)
            if np.linalg.norm(y - x) < 1e-8 * np.linalg.norm(x):
                return np.vdot(x, A @ x)
            x += 0.6 * (y - x)
            x /= np.sqrt(np.vdot(x, self.M @ x).real)
        pytest.fail("the iteration does not converge")


def test_the_backbone_of_a_free_assembly_is_that_of_its_whole_mesh(tiny):
    free = structure_of(freed(tiny))
    preload = apply_preload(free, 8e3)
    whole = WholeStructure(free, preload["normal_load"].to_numpy())
    assert np.all(whole.squared[:6] < 1e-6 * whole.squared[6])
    contact = {
        "law": "constant",
        "tangential_stiffness_N_per_m": STIFFNESS,
        "friction_coefficient": FRICTION,
    }
    condition = ContactCondition.of(contact, LOSS_FACTOR)
    options = ContactAdaptedBasis(resonances=1, states=12, maximum_vectors=60)
    modes = find_modes(free, "enriched-40", find_pod_modes(free, preload, [condition], options))
    joint = condition.connect(preload, modes)
    assert np.count_nonzero(joint.is_rigid) == 6
    window = frequency_window(joint)
    backbone = find_backbone(joint, [1.0, 1000.0], damping=LOSS_FACTOR, window=window)
    damping = backbone["damping_ratio"].to_numpy()
    # from where all sticks over the largest damping to where all slips
    last = int(np.flatnonzero(damping > 1.01 * LOSS_FACTOR / 2)[-1])
    for state in np.unique(np.linspace(0, last, 6).astype(int)):
        at = backbone.isel(state=state)
        frequency, ratio = float(at["natural_frequency"]), float(at["damping_ratio"])
        near = (2 * np.pi * frequency) ** 2 * (1 + 2j * ratio)
        expected = whole.mode(float(at["modal_amplitude"]), near)
        assert frequency == pytest.approx(np.sqrt(expected.real) / (2 * np.pi), rel=1e-6)
        assert ratio == pytest.approx(expected.imag / (2 * expected.real), rel=1e-4)
    assert damping.max() > 10 * LOSS_FACTOR / 2
