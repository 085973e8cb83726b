"""Several robots: who does what, in which sequence, and what may go on at once."""
