"""What stopped a robot, or waits for a person."""
