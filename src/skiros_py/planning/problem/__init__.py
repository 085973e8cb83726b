"""What of the world goes into a planning problem."""
