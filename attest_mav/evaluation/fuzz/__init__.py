"""Random inputs with invariants that must hold whatever comes: one seed is one run, and repeats it exactly."""
