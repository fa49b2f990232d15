"""shoecal: robots that calibrate the force sensors in their own feet.

The method only: no ROS, no serial port, no wall clock.
"""
