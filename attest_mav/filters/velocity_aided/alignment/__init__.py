"""Alignment in motion or at rest: collect readings, solve for the attitude, initialise the filter."""
