"""Goals and the task manager: goal in, skills planned and dispatched, report out."""
