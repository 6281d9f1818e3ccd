"""Recordings of the daemon's own work on disk; imported only where they are switched on."""
