"""Events of jobs sent to other systems: signed, in order, at least once."""
