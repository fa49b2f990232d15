"""The nodes: parameters, conversion, a call of the core, publish."""
