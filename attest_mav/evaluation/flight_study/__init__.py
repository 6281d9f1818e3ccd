"""Studies of the flight filter on recorded flights with truth, as they are and edited. ``parts`` is the way in."""
