"""Recorded flights as sources of samples. ``source`` is the protocol, ``formats`` the table of readable formats."""
