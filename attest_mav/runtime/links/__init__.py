"""Byte links that never block and never give up. ``open`` makes one from its URL."""
