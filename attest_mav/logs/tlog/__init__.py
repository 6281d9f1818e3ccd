"""Telemetry logs (tlog). ``source`` is the way in; ``survey`` is the first pass, ``reader`` the second."""
