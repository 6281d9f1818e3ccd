"""Replays: filters over recorded flights, compared with a reference. ``engine`` is the way in."""
