"""What happens, as one log; and what the robots do at this moment."""
