"""The daemon's work without I/O: bytes and time in, bytes and a snapshot out."""
