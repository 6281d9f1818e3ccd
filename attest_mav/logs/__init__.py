"""Recorded flights, read as the samples that a live link would have given."""
