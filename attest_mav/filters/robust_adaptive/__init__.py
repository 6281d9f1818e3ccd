"""The robust adaptive extended Kalman filter (paper 2). ``filter`` is the way in."""
