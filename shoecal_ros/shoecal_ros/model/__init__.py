"""What belongs to the node `model` alone."""
