"""Whose turn it is: the task that works at this moment, for which everything else may have to wait."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from skiros_py.tasks.control import Control

__all__ = ["Turn"]


class Turn:
    """The turns of the tasks of a cell; they take them in the control thread only."""

    def __init__(self) -> None:
        self._control: Control | None = None

    @contextmanager
    def of(self, control: Control) -> Iterator[None]:
        """Says, for as long as it is entered, that one task works."""
        self._control = control
        try:
            yield
        finally:
            self._control = None

    @property
    def stop_wanted(self) -> bool:
        """True when somebody wants the task to end that works now."""
        return self._control is not None and self._control.stop is not None
