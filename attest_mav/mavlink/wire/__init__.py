"""Frames in bytes: layout, checksum, walker, framer, sequence numbers."""
