"""An independent attitude for any MAVLink vehicle, and a verdict on the autopilot's own.

Read ``attest_mav.types`` first: it fixes units, frames and time for the whole package.
"""
