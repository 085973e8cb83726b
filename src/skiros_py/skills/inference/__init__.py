"""Parameters that were left out, found in the world: what fits the conditions under which a skill can start."""
