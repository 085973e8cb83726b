"""Event streams: events with replay, and the live state of the robots."""
