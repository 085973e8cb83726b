"""The timeline of a report: lanes of subsystems, with skills as bars and their parts below; and how it is drawn."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from skiros_py.execution.monitor import Status
from skiros_py.tasks.trace import TraceEventKind

_OVER = {Status.TERMINATED.value: "good", Status.ERROR.value: "bad", Status.PREEMPTED.value: "cut"}
_WAIT_ENDS = {
    TraceEventKind.STARTED,
    TraceEventKind.FINISHED,
    TraceEventKind.STOPPED,
    TraceEventKind.REPLANS,
    TraceEventKind.NO_PLAN,
}
_WAITS = "waits for "
"""What a module tells that waits for something which another one has."""
_ROWS = ("skill", "part", "primitive", "wait")
"""The order of rows in a lane: what was started by itself, skills within, primitives, waits."""


@dataclass(slots=True)
class Bar:
    """Something that took a while.

    Attributes:
        kind: "skill", "part" (a skill within a skill), "primitive" or "wait".
        label: What stands on it.
        start, end: Run time [s].
        how: "good", "bad", "cut" (cancelled), "open" (the record ends before it) or "wait".
        text: All that is known of it.
        row: Number of its row in its lane, from the top.
        x, y, width: Where it is drawn [px].
        shown: As much of the label as fits on it.
    """

    kind: str
    label: str
    start: float
    end: float
    how: str
    text: str
    row: int = 0
    x: float = 0.0
    y: float = 0.0
    width: float = 0.0
    shown: str = ""


@dataclass(slots=True)
class Lane:
    """What one subsystem did.

    Attributes:
        robot: The robot that it belongs to; empty where that is not known.
        agent: Its id.
        bars: What it did, in the order of their beginnings.
        rows: Number of rows.
        y, height: Where it is drawn [px].
    """

    robot: str
    agent: str
    bars: list[Bar] = field(default_factory=list)
    rows: int = 0
    y: float = 0.0
    height: float = 0.0


def span(
    events: Sequence[Mapping[str, Any]], trace: Sequence[Mapping[str, Any]], begin: float, end: float | None
) -> tuple[float, float]:
    """Returns the run times between which everything is [s]; never an empty span."""
    times = [begin, *(event["time"] for event in events), *(entry["time"] for entry in trace)]
    last = max(times) if end is None else max(end, *times)
    return min(times), max(last, min(times) + 0.1)


def lanes(
    events: Iterable[Mapping[str, Any]],
    trace: Iterable[Mapping[str, Any]],
    robots: Mapping[str, Sequence[str]],
    end: float,
) -> list[Lane]:
    """Puts what happened into lanes.

    Args:
        events: Events of the modules, in order.
        trace: What happened in the tasks, in order: what waited.
        robots: The devices and subsystems of each robot.
        end: Run time at which the record ends [s].
    """
    owners = {device: robot for robot, devices in robots.items() for device in devices}
    found: dict[str, Lane] = {}
    listed = list(events)
    for agent, bar in [*_bars(listed, end), *_waits_within(listed, end), *_waits(trace, end)]:
        found.setdefault(agent, Lane(owners.get(agent, ""), agent)).bars.append(bar)
    ordered = sorted(found.values(), key=lambda lane: (lane.robot, lane.agent))
    for lane in ordered:
        _arrange(lane)
    return ordered


def _bars(events: Iterable[Mapping[str, Any]], end: float) -> list[tuple[str, Bar]]:
    """Pairs the beginnings of modules with their ends."""
    bars: list[tuple[str, Bar]] = []
    running: dict[tuple[str, ...], list[Bar]] = {}
    for event in events:
        key = (event["kind"], event["module"], event["agent"], event["caller"])
        if event["status"] == Status.STARTED.value:
            bar = _begun(event, end)
            running.setdefault(key, []).append(bar)
            bars.append((event["agent"], bar))
        elif event["status"] in _OVER and running.get(key):
            _end(running[key].pop(), event)
    return bars


def _begun(event: Mapping[str, Any], end: float) -> Bar:
    kind = "primitive" if event["kind"] == "primitive" else "part" if event["caller"] else "skill"
    label = " ".join(filter(None, (event["module"], event["target"])))
    return Bar(kind, label, event["time"], end, "open", event["text"])


def _end(bar: Bar, event: Mapping[str, Any]) -> None:
    bar.end, bar.how = event["time"], _OVER[event["status"]]
    said = {"good": "done", "bad": "failed", "cut": "cancelled"}[bar.how]
    bar.text = "\n".join(filter(None, (bar.text, f"{said}: {event['text']}" if event["text"] else said)))


def _waits_within(events: Iterable[Mapping[str, Any]], end: float) -> list[tuple[str, Bar]]:
    """Returns what waited while it ran: until the next event of its subsystem."""
    waits: list[tuple[str, Bar]] = []
    open_: dict[str, Bar] = {}
    for event in events:
        agent = event["agent"]
        if agent in open_:
            open_.pop(agent).end = event["time"]
        if event["status"] == Status.RUNNING.value and event["text"].startswith(_WAITS):
            text = f"{event['module']} {event['text']}"
            open_[agent] = Bar("wait", event["text"], event["time"], end, "wait", text)
            waits.append((agent, open_[agent]))
    return waits


def _waits(trace: Iterable[Mapping[str, Any]], end: float) -> list[tuple[str, Bar]]:
    """Returns what waited: until the step started, or there was another plan."""
    waits: list[tuple[str, Bar]] = []
    open_: dict[tuple[object, ...], list[Bar]] = {}
    for entry in trace:
        step = (entry["task"], entry["skill"], *sorted(entry["arguments"].items()))
        if entry["what"] == TraceEventKind.WAITS and entry["agent"]:
            bar = Bar("wait", f"{entry['skill']} waits", entry["time"], end, "wait", entry["text"])
            open_.setdefault(step, []).append(bar)
            waits.append((entry["agent"], bar))
        elif entry["what"] in _WAIT_ENDS:
            over = [step] if entry["step"] is not None else [key for key in open_ if key[0] == entry["task"]]
            for bar in (bar for key in over for bar in open_.pop(key, ())):
                bar.end = entry["time"]
    return waits


def _arrange(lane: Lane) -> None:
    """Gives each bar a row in which it overlaps no other."""
    lane.bars.sort(key=lambda bar: bar.start)
    for kind in _ROWS:
        ends: list[float] = []
        for bar in (bar for bar in lane.bars if bar.kind == kind):
            free = next((row for row, end in enumerate(ends) if end <= bar.start + 1e-9), len(ends))
            ends[free : free + 1] = [bar.end]
            bar.row = lane.rows + free
        lane.rows += len(ends)


# ---------------------------------------------------------------- drawn


_MARGIN, _TOP = 130.0, 26.0
_ROW, _GAP = 20.0, 10.0
_NARROWEST, _WIDEST = 900.0, 12_000.0
"""Bounds of the width of the time axis [px]."""
_PER_SECOND = 12.0
"""Width of a second where it fits the bounds [px]."""
_LETTER = 6.6
"""Width of a letter [px]."""
_TICK = 90.0
"""Least distance between two ticks [px]."""


@dataclass(frozen=True, slots=True)
class Drawing:
    """What is drawn besides lanes and bars [px].

    Attributes:
        width, height: Of the whole.
        left: Where the axis begins.
        row: Height of a bar.
        ticks: Place and run time [s] of each tick.
        marks: Place and number of each picture, from 1.
    """

    width: float
    height: float
    left: float
    row: float
    ticks: tuple[tuple[float, str], ...]
    marks: tuple[tuple[float, int], ...]


def draw(lanes: Sequence[Lane], begin: float, end: float, pictures: Sequence[float]) -> Drawing:
    """Places lanes and bars on a drawing of a timeline, and returns the rest of it.

    Args:
        lanes: The lanes.
        begin: Run time at its left end [s].
        end: Run time at its right end [s].
        pictures: Run times of the pictures [s].
    """
    axis = min(max(_NARROWEST, (end - begin) * _PER_SECOND), _WIDEST)
    scale = axis / (end - begin)

    def place(time: float) -> float:
        return round(_MARGIN + (time - begin) * scale, 2)

    y = _TOP
    for lane in lanes:
        lane.y, lane.height = y, lane.rows * _ROW
        for bar in lane.bars:
            bar.x, bar.y = place(bar.start), y + bar.row * _ROW + 2.0
            bar.width = round(max(place(bar.end) - bar.x, 1.0), 2)
            bar.shown = _cut(bar.label, bar.width)
        y += lane.height + _GAP
    ticks = tuple((place(time), f"{time:g}") for time in _ticks(begin, end, _TICK / scale))
    marks = tuple((place(time), number) for number, time in enumerate(pictures, 1))
    return Drawing(_MARGIN + axis + 10.0, y + _TOP, _MARGIN, _ROW - 4.0, ticks, marks)


def _cut(label: str, width: float) -> str:
    letters = int((width - 6.0) / _LETTER)
    return label if len(label) <= letters else label[: letters - 1] + "…" if letters > 2 else ""


def _ticks(begin: float, end: float, least: float) -> list[float]:
    """Returns round times between two others, at least so far apart."""
    power = 10.0 ** math.floor(math.log10(least))
    step = next(power * factor for factor in (1, 2, 5, 10) if power * factor >= least)
    first = math.ceil(begin / step - 1e-9)
    return [round(number * step, 6) for number in range(first, math.floor(end / step + 1e-9) + 1)]
