"""From raw channel readings to ground reaction force (GRF) and centre of pressure (CoP)."""
