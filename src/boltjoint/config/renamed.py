"""Keys and values of earlier versions: they are refused with what stands in their place."""

from collections.abc import Mapping

#: new key, by the dotted path of the old one in its file
RENAMED_KEYS: Mapping[str, str] = {
    "enrichment": "contact_adapted_basis",
    "contact_adapted_basis.most": "maximum_vectors",
    "solver.friction": "friction_force",
    "solver.samples": "time_samples",
    "solver.renewal": "basis_update",
    "solver.static_share": "quasi_static_correction",
    "solver.most_iterations": "maximum_iterations",
    "solver.most_solutions": "maximum_solutions",
    "fitting.starts": "initial_guesses",
    "timing.enough_s": "time_budget_s",
    "march_forces_N": "verification_forces_N",
}
#: where a key of the assembly is now
MOVED_KEYS: Mapping[str, str] = {
    "excitation": "a key of the case, with kind: forces",
    "response": "the first of sensors in the case",
}
_BY_CASES = "no longer a key: bases are made for the contact and damping of the cases"
_BY_BACKBONES = "no longer a key: backbones, of contact_adapted_basis.states each, take its place"
#: what is said of a key that has none in its place, by its dotted path
REMOVED_KEYS: Mapping[str, str] = {
    "contact_adapted_basis.contact_stiffness_N_per_m": _BY_CASES,
    "contact_adapted_basis.friction_coefficient": _BY_CASES,
    "contact_adapted_basis.loss_factor": _BY_CASES,
    "contact_adapted_basis.slip_levels": _BY_BACKBONES,
    "contact_adapted_basis.levels": _BY_BACKBONES,
}
#: new value, by the dotted path of the key and the old value
RENAMED_VALUES: Mapping[str, Mapping[str, str]] = {
    "solver.friction_force": {"exact": "analytic", "sampled": "aft"},
    "solver.basis_update": {"within": "implicit", "after": "lagged"},
}
