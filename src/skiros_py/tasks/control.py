"""Control requests to a running task: made in any thread, applied in the control cycle."""

from __future__ import annotations

import enum
import threading


class Mode(enum.Enum):
    """How a task proceeds."""

    RUN = "run"
    """Without pauses."""
    PAUSE = "pause"
    """Paused: running steps come to a standstill."""
    SINGLE = "single"
    """Until the running steps have ended; if none runs, the next ready steps start first."""


class Control:
    """The control requests for one task, from any thread. The last mode requested counts, but the first stop.

    Attributes:
        mode: The requested mode.
        stop: Why it was asked to stop; None if it was not.
    """

    def __init__(self) -> None:
        self.mode = Mode.RUN
        self.stop: str | None = None
        self._guard = threading.Lock()

    def wish(self, mode: Mode) -> None:
        """Requests another mode."""
        with self._guard:
            self.mode = mode

    def end_single(self) -> Mode:
        """Pauses after a single step, unless another mode was requested meanwhile; returns the resulting mode."""
        with self._guard:
            if self.mode is Mode.SINGLE:
                self.mode = Mode.PAUSE
            return self.mode

    def end(self, reason: str) -> None:
        """Requests a stop; the first reason counts."""
        with self._guard:
            if self.stop is None:
                self.stop = reason


class StopWanted(Exception):
    """The task was asked to stop; the text gives the reason."""
