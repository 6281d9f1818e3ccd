"""Telemetry logs (tlog) as a source of samples. ``survey`` is the first pass, ``reader`` the second."""
