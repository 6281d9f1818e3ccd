"""The aids of the flight filter, one module each: its measurement, and its use or rejection."""
