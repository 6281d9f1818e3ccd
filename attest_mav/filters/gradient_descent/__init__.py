"""The gradient-descent filter (paper 1) and its options for hand-held use. ``filter`` is the way in."""
