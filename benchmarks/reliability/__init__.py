"""What is done to the suite by `make faults`, a row a module, and what must hold."""
