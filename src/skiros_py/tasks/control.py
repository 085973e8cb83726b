"""What people want of a task that is under way: wishes from any thread, obeyed in the control cycle."""

from __future__ import annotations

import enum

__all__ = ["Control", "Mode"]


class Mode(enum.Enum):
    """How a task shall go on."""

    RUN = "run"
    """As fast as it can."""
    PAUSE = "pause"
    """Not at all: what runs comes to a standstill."""
    SINGLE = "single"
    """Until what runs has ended; where nothing runs, the next possible steps start first."""


class Control:
    """The wishes for one task. Each is one assignment, so any thread may wish.

    Attributes:
        mode: How it shall go on.
        stop: Why it shall end; None while it may go on.
    """

    def __init__(self) -> None:
        self.mode = Mode.RUN
        self.stop: str | None = None

    def end(self, reason: str) -> None:
        """Wants it to end; the first reason counts."""
        if self.stop is None:
            self.stop = reason
