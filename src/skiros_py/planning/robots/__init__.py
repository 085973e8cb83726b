"""Multi-robot planning: allocation, ordering and concurrency."""
