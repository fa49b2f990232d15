"""A simulated robot on simulated force-sensing shoes: physics, sensors, and the truth."""
