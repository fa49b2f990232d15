"""The serial side of shoecal: bytes from a device to stamped voltages, without ROS.

`driver.open_driver` puts the pieces together; `device.SimulatedDevice` is the other end.
"""
