"""The leveling extended Kalman filter (paper 3). ``filter`` is the way in."""
