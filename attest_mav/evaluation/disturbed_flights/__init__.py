"""Flights of the whole service beside a fake autopilot while the link, the vehicle or strangers disturb them."""
