"""What all nodes share: process, health, messages, quality of service, actions, workers."""
