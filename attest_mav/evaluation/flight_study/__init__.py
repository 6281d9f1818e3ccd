"""Studies of the flight filter on recorded flights with truth: starts, outages, worse sensors. ``parts`` is the way in."""
