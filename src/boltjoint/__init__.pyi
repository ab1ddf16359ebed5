"""Types of the names that ``__init__.py`` imports when they are first asked for."""

from boltjoint.calibration.bolt_preloads import BoltPreloads as BoltPreloads
from boltjoint.calibration.fit import fit as fit
from boltjoint.calibration.fit_preloads import fit_preloads as fit_preloads
from boltjoint.calibration.fit_preloads import loosest_bolt as loosest_bolt
from boltjoint.calibration.measured_backbone import MeasuredBackbone as MeasuredBackbone
from boltjoint.calibration.measured_response import MeasuredResponse as MeasuredResponse
from boltjoint.calibration.parameters import Parameter as Parameter
from boltjoint.dynamics.backbone.backbone import find_backbone as find_backbone
from boltjoint.dynamics.backbone.backbone_at import backbone_at as backbone_at
from boltjoint.dynamics.reduction.basis_from_backbones import find_pod_modes as find_pod_modes
from boltjoint.dynamics.reduction.contact_condition import (
    ContactCondition as ContactCondition,
)
from boltjoint.dynamics.reduction.hyper_reduction import weigh_pairs as weigh_pairs
from boltjoint.dynamics.response.branch import Branch as Branch
from boltjoint.dynamics.response.converged_peaks import (
    find_converged_peaks as find_converged_peaks,
)
from boltjoint.dynamics.response.frequency_response import solve_branch as solve_branch
from boltjoint.dynamics.response.frequency_response import solve_response as solve_response
from boltjoint.dynamics.response.methods import LinearModes as LinearModes
from boltjoint.dynamics.response.methods import ResponseDependentModes as ResponseDependentModes
from boltjoint.dynamics.response.response_file import by_force as by_force
from boltjoint.dynamics.response.synthesis import ModalSynthesis as ModalSynthesis
from boltjoint.dynamics.response.windows import Resonance as Resonance
from boltjoint.dynamics.response.windows import frequency_window as frequency_window
from boltjoint.friction.constant import ConstantLoad as ConstantLoad
from boltjoint.friction.variable import VariableLoad as VariableLoad
from boltjoint.joint.derived import merge_points as merge_points
from boltjoint.joint.derived import rescale_contact as rescale_contact
from boltjoint.joint.io import load_joint as load_joint
from boltjoint.joint.model import Joint as Joint
from boltjoint.joint.node_to_node import connect_nodes as connect_nodes
from boltjoint.joint.partition import partition_regions as partition_regions
from boltjoint.joint.reduced import fit_reduced_joint as fit_reduced_joint
from boltjoint.measurement.identification import identify_ring_down as identify_ring_down
from boltjoint.measurement.signals import read_signals as read_signals
from boltjoint.measurement.simulated_ring_down import simulate_ring_down as simulate_ring_down
from boltjoint.solvers.step_control import StepControl as StepControl
from boltjoint.structure.contact_points import ContactPoints as ContactPoints
from boltjoint.structure.model import Structure as Structure
from boltjoint.structure.modes import find_modes as find_modes
from boltjoint.structure.preload import apply_preload as apply_preload

__version__: str
