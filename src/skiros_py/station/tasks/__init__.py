"""Tasks under way, and previews of goals."""
