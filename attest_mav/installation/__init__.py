"""The service on a machine: unit files, user, names of serial ports, example configurations, and how they get there."""
