"""Logs, one line per record, and Prometheus metrics of requests, jobs and the control cycle.

Modules and plug-ins use Python's own :mod:`logging` and do not depend on this module.
"""

from __future__ import annotations

import logging
import sys
import threading
import traceback
from collections import Counter as Counts
from collections.abc import Iterable, MutableMapping
from contextvars import ContextVar
from typing import Any, Literal, TextIO

import structlog
from prometheus_client import CollectorRegistry, GCCollector, Histogram, PlatformCollector, ProcessCollector
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector
from starlette.requests import Request

from skiros_py.errors import escaped
from skiros_py.server.problems import PREFIX
from skiros_py.station.control import ControlThread
from skiros_py.station.events.log import Event, EventLog, Kind
from skiros_py.station.jobs.views import state_name
from skiros_py.station.session import Session

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
    console = structlog.dev.ConsoleRenderer(colors=stream.isatty(), exception_formatter=_write_traceback)
    last: list[structlog.types.Processor] = (
        [_TRACEBACKS, structlog.processors.JSONRenderer()] if form == "json" else [_escaped, console]
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


def _escaped(
    _logger: Any, _name: str, entry: MutableMapping[str, Any]
) -> MutableMapping[str, Any]:  # structlog's signature
    """Escapes all texts of a record, which come from anywhere: they must not look like more records."""
    kept = {name: entry.pop(name) for name in ("exc_info", "exception") if name in entry}
    if "stack" in entry:
        kept["stack"] = _indented(entry.pop("stack"))
    texts = {escaped(name): escaped(value if isinstance(value, str) else repr(value)) for name, value in entry.items()}
    return {**texts, **kept}


def _write_traceback(stream: TextIO, error: structlog.typing.ExcInfo) -> None:
    """Writes a traceback below its record; no line of it begins like a record."""
    stream.write("\n" + _indented("".join(traceback.format_exception(*error))))


def _indented(text: str) -> str:
    return "\n".join(f"  {escaped(line)}" for line in text.splitlines())


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


_BOUNDS = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0)


class Metrics(Collector):
    """The metrics of one server.

    Most metrics are read from the station when they are collected; only requests are counted as they are answered.

    Args:
        control: Runs the session.
        events: The event log.

    Attributes:
        registry: All metrics, to add further ones or to export them.
    """

    def __init__(self, control: ControlThread, events: EventLog) -> None:
        self._control = control
        self._events = events
        self.registry = CollectorRegistry()
        ProcessCollector(registry=self.registry)
        PlatformCollector(registry=self.registry)
        GCCollector(registry=self.registry)
        self._requests = Histogram(
            "skiros_http_request_seconds",
            "Time from a request's arrival to the end of its answer.",
            ("method", "route", "status"),
            buckets=_BOUNDS,
            registry=self.registry,
        )
        self.registry.register(self)

    def took(self, request: Request, status: int, seconds: float) -> None:
        """Counts a request. Labels are templates of paths and known methods, so that callers cannot create many.

        Args:
            request: The request.
            status: Status of the answer.
            seconds: Its duration [s].
        """
        route = getattr(request.scope.get("route"), "path_format", "").removeprefix(PREFIX) or "none"
        method = request.method if request.method in _METHODS else "other"
        self._requests.labels(method, route, str(status)).observe(seconds)

    def collect(self) -> Iterable[Metric]:
        """Yields the metrics of the station at this moment."""
        yield CounterMetricFamily("skiros_cycles", "Control cycles since the server started.", self._control.beat)
        yield CounterMetricFamily("skiros_events", "Events since the server started.", self._events.last)
        yield GaugeMetricFamily("skiros_ready", "1 while the station runs.", float(self._control.alive))
        if self._control.alive:
            yield from _of_session(self._control.session)


_METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})


def _of_session(session: Session) -> Iterable[Metric]:
    cycle, board, gauge = session.cycle, session.cycle.board, GaugeMetricFamily
    yield gauge("skiros_halted", "1 while everything is halted.", float(bool(cycle.halted)))
    yield gauge("skiros_run_time_seconds", "Run time of the station.", board.snapshot.time)
    yield gauge("skiros_cycle_period_seconds", "Length of one control cycle.", board.period)
    yield gauge("skiros_world_version", "Number of the last change of the world.", session.world.version)
    yield gauge("skiros_questions_open", "Questions that wait for a person.", len(session.questions.open))
    yield gauge("skiros_tasks_under_way", "Tasks under way.", len(session.tasks.active))
    jobs = gauge("skiros_jobs_open", "Jobs that are not over, by state.", labels=("state",))
    for state, number in Counts(state_name(job.state).value for job in session.jobs.open.values()).items():
        jobs.add_metric((state,), number)
    yield jobs
