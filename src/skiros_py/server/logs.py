"""Logs: one line for each thing that happened, as JSON or for people, with the job that it belongs to.

Modules and plug-ins log with Python's own :mod:`logging` and need to know nothing of this.
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
"""The request that is being answered in this context; empty outside of one."""

_log = logging.getLogger("skiros_py.jobs")


def log_to(stream: TextIO = sys.stderr, *, form: LogForm = "console", level: int = logging.INFO) -> None:
    """Has everything that is logged in this process written to a stream; called again, it replaces the first.

    Args:
        stream: Where to.
        form: "json": one JSON object a line; "console": for people.
        level: What is less important is left out.
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
    for loud in ("httpx2", "httpcore2", "uvicorn"):  # what they say in good times is what our own log has
        logging.getLogger(loud).setLevel(max(level, logging.WARNING))


_HANDLER = "skiros"
_TRACEBACKS = structlog.processors.ExceptionRenderer(
    structlog.tracebacks.ExceptionDictTransformer(show_locals=False, max_frames=20)
)
"""Without the values of variables: keys may be among them."""


def _with_request(
    _logger: Any, _name: str, entry: MutableMapping[str, Any]
) -> MutableMapping[str, Any]:  # structlog's signature
    """Names the request in whose course something is logged."""
    request = request_id.get()
    for twice in ("color_message", "message", "asctime"):  # of uvicorn, and of other handlers of the same record
        entry.pop(twice, None)
    return {**entry, "request": request} if request else entry


def job_events_logged(events: EventLog) -> None:
    """Has every new state of a job, and each step of a task, logged with the job's id.

    Args:
        events: What happens; it is told at most once of each event, in the thread where it happened.
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
