"""Keys and values that earlier versions called otherwise: they are refused with their new name."""

from collections.abc import Mapping

#: new key, by the dotted path of the old one in its file
RENAMED_KEYS: Mapping[str, str] = {
    "enrichment": "contact_adapted_basis",
    "contact_adapted_basis.levels": "slip_levels",
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
#: new value, by the dotted path of the key and the old value
RENAMED_VALUES: Mapping[str, Mapping[str, str]] = {
    "solver.friction_force": {"exact": "analytic", "sampled": "aft"},
    "solver.basis_update": {"within": "implicit", "after": "lagged"},
}
