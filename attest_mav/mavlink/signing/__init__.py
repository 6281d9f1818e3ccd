"""Signatures of MAVLink 2: made for frames that are sent, verified in frames that arrive."""
