"""What acts on the robot from outside: ropes, hands, loads, the floor that is gone."""
