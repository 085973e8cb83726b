"""The event log, and the live state of the robots."""
