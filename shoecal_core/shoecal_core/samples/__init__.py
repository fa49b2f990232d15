"""From a recorded session to samples: joints, readings and model at the same instants."""
