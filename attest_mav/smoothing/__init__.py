"""The fixed-interval smoother: the attitude of a recorded flight from the readings before and behind each instant."""
