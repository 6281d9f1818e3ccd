"""Damaged logs: what stands intact in them, and what each reader finds. ``tools/damage_logs`` runs the campaign."""
