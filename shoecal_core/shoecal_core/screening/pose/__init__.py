"""Where the feet stand and how the base leans, by joints, base pose and IMU together."""
