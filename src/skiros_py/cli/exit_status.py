"""Exit statuses of ``skiros``."""

from __future__ import annotations

REACHED = 0
"""The goal holds: by the simulator's truth, or by belief where a fake ran."""
NOT_REACHED = 1
"""It does not, or something broke on the way."""
DIFFERENT = 1
"""Two things that were compared are not equal, or a copy is not current."""
USAGE = 2
"""Wrong usage, or a file that cannot be understood; nothing was started."""
NO_PLAN = 3
"""No plan leads to the goal; nothing was done."""
STOPPED = 130
"""Somebody stopped it."""
