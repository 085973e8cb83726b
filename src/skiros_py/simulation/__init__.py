"""Robot cells that exist only here: PyBullet with physics, the fake without, and the truth for tests and reports."""
