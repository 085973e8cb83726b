"""Functions that others want called when something happens."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Generic, ParamSpec

from skiros_py.interruptions import not_the_authors

P = ParamSpec("P")

_log = logging.getLogger(__name__)


class Listeners(Generic[P]):
    """Calls each listener with each event, in the order in which they were added; for any thread.

    A listener that raises is logged, and the others are still called: observers must not break what they observe.

    Args:
        events: What they are called with, for the log ("module events").
    """

    def __init__(self, events: str) -> None:
        self._events = events
        self._listeners: list[Callable[P, object]] = []

    def add(self, listener: Callable[P, object]) -> Callable[[], None]:
        """Calls the listener from now on; it must be quick. Returns how to end that."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def notify(self, *args: P.args, **kwargs: P.kwargs) -> None:
        """Calls all listeners."""
        for listener in tuple(self._listeners):
            try:
                listener(*args, **kwargs)
            except BaseException as error:  # whatever it is, it is the listener's fault
                if not_the_authors(error):
                    raise
                _log.exception("a listener of %s broke", self._events)

    def __len__(self) -> int:
        return len(self._listeners)
