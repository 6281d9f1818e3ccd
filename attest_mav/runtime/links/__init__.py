"""Byte links that never block and never give up. ``attest_mav.runtime.links.open`` makes one from its URL."""
