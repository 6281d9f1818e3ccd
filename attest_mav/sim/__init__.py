"""The fake autopilot: a true motion, sensor errors and a MAVLink personality; no I/O."""
