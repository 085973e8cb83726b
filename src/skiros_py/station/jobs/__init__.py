"""Orders: goals as texts, templates, results of jobs."""
