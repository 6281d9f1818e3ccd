"""Argument parsing and wording; nothing else."""
