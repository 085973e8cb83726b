"""Who may do what: keys, roles, limits, and the log of what was done."""
