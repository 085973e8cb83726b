"""What people want of a task that is under way: wishes from any thread, obeyed in the control cycle."""

from __future__ import annotations

import enum
import threading


class Mode(enum.Enum):
    """How a task shall go on."""

    RUN = "run"
    """As fast as it can."""
    PAUSE = "pause"
    """Not at all: what runs comes to a standstill."""
    SINGLE = "single"
    """Until what runs has ended; where nothing runs, the next possible steps start first."""


class Control:
    """The wishes for one task. Any thread may wish: of each kind the last wish counts, of stops the first.

    Attributes:
        mode: How it shall go on.
        stop: Why it shall end; None while it may go on.
    """

    def __init__(self) -> None:
        self.mode = Mode.RUN
        self.stop: str | None = None
        self._guard = threading.Lock()

    def wish(self, mode: Mode) -> None:
        """Wants it to go on in another way."""
        with self._guard:
            self.mode = mode

    def end_single(self) -> Mode:
        """Pauses after a single step, unless somebody wants something else by now; returns how it shall go on."""
        with self._guard:
            if self.mode is Mode.SINGLE:
                self.mode = Mode.PAUSE
            return self.mode

    def end(self, reason: str) -> None:
        """Wants it to end; the first reason counts."""
        with self._guard:
            if self.stop is None:
                self.stop = reason


class StopWanted(Exception):
    """Somebody wants the task to end; its text says why."""
