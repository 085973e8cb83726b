"""Recordings of runs and jobs: which topics they have, where they are kept, and the replay of a job."""
