"""What happens, as streams: events with replay, and the robots' live state."""
