"""Access control: keys, roles, limits, and the audit log."""
