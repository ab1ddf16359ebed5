"""Nonlinear vibration of bolted joints, from dimensions to frequency responses."""

from importlib import import_module
from importlib.metadata import PackageNotFoundError, version

try:
    __version__ = version("boltjoint")
except PackageNotFoundError:
    #: of a checkout that is imported without being installed
    __version__ = "0+unknown"

#: what users of the library call, by the module that holds it; imported when first asked for, since
#: compiled modules take their time
_NAMES = {
    "BoltPreloads": "calibration.bolt_preloads",
    "Branch": "dynamics.response.branch",
    "ConstantLoad": "friction.constant",
    "ContactCondition": "dynamics.reduction.contact_condition",
    "ContactPoints": "structure.contact_points",
    "Joint": "joint.model",
    "LinearModes": "dynamics.response.methods",
    "MeasuredBackbone": "calibration.measured_backbone",
    "MeasuredResponse": "calibration.measured_response",
    "ModalSynthesis": "dynamics.response.synthesis",
    "Parameter": "calibration.parameters",
    "Resonance": "dynamics.response.windows",
    "ResponseDependentModes": "dynamics.response.methods",
    "StepControl": "solvers.step_control",
    "Structure": "structure.model",
    "VariableLoad": "friction.variable",
    "apply_preload": "structure.preload",
    "backbone_at": "dynamics.backbone.backbone_at",
    "by_force": "dynamics.response.response_file",
    "connect_nodes": "joint.node_to_node",
    "find_backbone": "dynamics.backbone.backbone",
    "find_converged_peaks": "dynamics.response.converged_peaks",
    "find_modes": "structure.modes",
    "find_pod_modes": "dynamics.reduction.basis_from_backbones",
    "fit": "calibration.fit",
    "fit_preloads": "calibration.fit_preloads",
    "fit_reduced_joint": "joint.reduced",
    "frequency_window": "dynamics.response.windows",
    "identify_ring_down": "measurement.identification",
    "load_joint": "joint.io",
    "loosest_bolt": "calibration.fit_preloads",
    "merge_points": "joint.derived",
    "partition_regions": "joint.partition",
    "read_signals": "measurement.signals",
    "rescale_contact": "joint.derived",
    "simulate_ring_down": "measurement.simulated_ring_down",
    "solve_branch": "dynamics.response.frequency_response",
    "solve_response": "dynamics.response.frequency_response",
    "weigh_pairs": "dynamics.reduction.hyper_reduction",
}

__all__ = [*_NAMES]


def __getattr__(name: str) -> object:
    """A name of the library, from the module that holds it."""
    if name not in _NAMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"boltjoint.{_NAMES[name]}"), name)


def __dir__() -> list[str]:
    """The names above beside the module's own."""
    return sorted([*globals(), *_NAMES])
