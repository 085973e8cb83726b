"""What stands behind the routes about the world: telling it, editing it, asking it."""
