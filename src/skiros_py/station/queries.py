"""SPARQL queries of callers: executed in a separate process, which may be killed."""

from __future__ import annotations

import threading
from collections.abc import Mapping

from skiros_py.errors import Busy, DeviceError
from skiros_py.station.control import ControlThread
from skiros_py.station.session import Session
from skiros_py.world.queries import Binding, Result
from skiros_py.world.queries.outside import Limits, OutsideQueries

_LIMITS = Limits()


class Queries:
    """Answers queries about the world of the present session.

    Args:
        control: Notifies of the begin and end of sessions.
        limits: Resource limits of one query.
    """

    def __init__(self, control: ControlThread, limits: Limits = _LIMITS) -> None:
        self._limits = limits
        self._turns = threading.BoundedSemaphore(limits.at_once)
        self._outside: OutsideQueries | None = None
        control.on_open(self._open)
        control.on_close(self._close)

    def answer(self, sparql: str, bindings: Mapping[str, Binding], *, entailed: bool, time_limit: float) -> Result:
        """Answers a query.

        Args:
            sparql: The query.
            bindings: Values of its parameters.
            entailed: True to include triples entailed by OWL.
            time_limit: Maximum duration [s].

        Raises:
            UsageError: It cannot be answered, or not within its limits; the text gives the reason.
            Busy: Too many queries are being answered already, or the station is being opened.
        """
        if not self._turns.acquire(blocking=False):
            raise Busy(f"{self._limits.at_once} questions are being answered already: ask again later")
        try:
            return self._answer(sparql, bindings, entailed=entailed, time_limit=time_limit)
        finally:
            self._turns.release()

    def _answer(self, sparql: str, bindings: Mapping[str, Binding], *, entailed: bool, time_limit: float) -> Result:
        outside = self._outside
        if outside is None:
            raise Busy("the station is not running: ask again later")
        try:
            return outside.query(sparql, bindings, entailed=entailed, time_limit=time_limit)
        except DeviceError:
            if self._outside is outside:
                raise
            raise Busy("the station was closed meanwhile: ask again later") from None

    def _open(self, session: Session) -> None:
        self._outside = OutsideQueries(session.world, self._limits)

    def _close(self, _session: Session) -> None:
        outside, self._outside = self._outside, None
        if outside is not None:
            outside.close()
