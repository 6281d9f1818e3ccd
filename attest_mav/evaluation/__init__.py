"""Comparisons with a reference, the papers' scenarios, metrics and reports."""
