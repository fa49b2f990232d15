"""The simulator: the simulated robot on ROS time."""
