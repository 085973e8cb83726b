"""Orders: goals as texts, templates, what came of a job."""
