"""Webhooks: sends events of jobs to other systems, signed, in order, and at least once."""
