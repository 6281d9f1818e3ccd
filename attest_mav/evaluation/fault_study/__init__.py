"""Faults of sensors and receivers, recorded or put into samples: who sees them, how soon, and at what cost."""
