"""Frames to samples in SI units: readers, unit table, clocks, parameters of autopilots."""
