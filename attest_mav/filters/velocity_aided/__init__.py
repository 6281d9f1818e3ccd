"""The velocity-aided flight filter. ``filter`` is the way in, ``control`` its step in flight."""
