"""Active tasks, and previews of goals."""
