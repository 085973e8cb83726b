"""Recordings of runs and jobs: their topics and files, and the replay of a job."""
