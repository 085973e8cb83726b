"""Logs: one line per record, as JSON or for people, with the id of the job to which it belongs.

Modules and plug-ins use Python's own :mod:`logging` and do not depend on this module.
"""

from __future__ import annotations

import logging
import sys
import threading
from collections.abc import MutableMapping
from contextvars import ContextVar
from typing import Any, Literal, TextIO

import structlog

from skiros_py.station.events.event import Event, Kind
from skiros_py.station.events.log import EventLog

LogForm = Literal["console", "json"]

request_id: ContextVar[str] = ContextVar("request_id", default="")
"""The request being answered in this context; empty outside of requests."""

_log = logging.getLogger("skiros_py.jobs")


def log_to(stream: TextIO = sys.stderr, *, form: LogForm = "console", level: int = logging.INFO) -> None:
    """Writes all log records of this process to a stream; a second call replaces the first.

    Args:
        stream: The stream.
        form: "json": one JSON object a line; "console": for people.
        level: Records below this level are omitted.
    """
    shared: list[structlog.types.Processor] = [
        structlog.stdlib.add_log_level,
        structlog.stdlib.add_logger_name,
        structlog.stdlib.ExtraAdder(),
        structlog.processors.TimeStamper(fmt="iso", utc=True),
        _with_request,
    ]
    last: list[structlog.types.Processor] = (
        [_TRACEBACKS, structlog.processors.JSONRenderer()]
        if form == "json"
        else [structlog.dev.ConsoleRenderer(colors=stream.isatty(), exception_formatter=structlog.dev.plain_traceback)]
    )
    formatter = structlog.stdlib.ProcessorFormatter(
        foreign_pre_chain=shared, processors=[structlog.stdlib.ProcessorFormatter.remove_processors_meta, *last]
    )
    handler = logging.StreamHandler(stream)
    handler.setFormatter(formatter)
    handler.set_name(_HANDLER)
    root = logging.getLogger()
    for old in [one for one in root.handlers if one.get_name() == _HANDLER]:
        root.removeHandler(old)
    root.addHandler(handler)
    root.setLevel(level)
    for loud in ("httpx2", "httpcore2", "uvicorn"):  # their routine records duplicate our own log
        logging.getLogger(loud).setLevel(max(level, logging.WARNING))


_HANDLER = "skiros"
_TRACEBACKS = structlog.processors.ExceptionRenderer(
    structlog.tracebacks.ExceptionDictTransformer(show_locals=False, max_frames=20)
)
"""Tracebacks without the values of variables, which may contain keys."""


def _with_request(
    _logger: Any, _name: str, entry: MutableMapping[str, Any]
) -> MutableMapping[str, Any]:  # structlog's signature
    """Adds the id of the request during which a record is logged."""
    request = request_id.get()
    for twice in ("color_message", "message", "asctime"):  # added by uvicorn, and by other handlers of the same record
        entry.pop(twice, None)
    return {**entry, "request": request} if request else entry


def job_events_logged(events: EventLog) -> None:
    """Logs every new state of a job, and each step of a task, with the job's id.

    Args:
        events: The event log; the listener is called at most once per event, in the thread of the event.
    """
    seen, guard = events.last, threading.Lock()

    def look() -> None:
        nonlocal seen
        with guard:
            new = events.since(seen)
            seen = new[-1].number if new else seen
        for event in new:
            if event.kind in (Kind.JOB, Kind.TASK, Kind.ALARM, Kind.SYSTEM):
                _tell(event)

    events.on_event(look)


def _tell(event: Event) -> None:
    text = str(event.data.get("text") or event.data.get("detail") or "")
    words = " ".join(part for part in (event.kind.value, event.subject, event.type, text) if part)
    about = {"job": event.job} if event.job else {}
    _log.info(words, extra={**about, "number": event.number, "run_time": round(event.time, 3)})
