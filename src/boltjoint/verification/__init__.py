"""Solutions checked by methods independent of the solvers."""
