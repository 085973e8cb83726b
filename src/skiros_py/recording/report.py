"""A page about a run: one file with timeline, pictures and sentences, that opens from the disk without a network."""

from __future__ import annotations

import base64
import time
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from itertools import islice
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, UndefinedError

from skiros_py.errors import FileError
from skiros_py.recording.reader import Picture, Recording
from skiros_py.recording.timeline import draw, lanes, span
from skiros_py.world.scene.files import describe

_MOST_PICTURES = 120
_MOST_ROWS = 3000
"""Changes, and entries of the trace, that a page shows."""
_MOST_EDITS = 12
_KIND_OF_TASK = {"reached": "good", "held already": "good", "partly reached": "part", "stopped": "part"}


def report_page(recording: Recording) -> str:
    """Returns the page about a run as HTML.

    Raises:
        FileError: The record is damaged.
    """
    try:
        return _page(recording)
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError, UndefinedError) as error:
        raise FileError(recording.path, f"the recording is damaged: {type(error).__name__}: {error}") from error


def _page(recording: Recording) -> str:
    meta, events, trace = recording.meta, recording.events, recording.trace
    ended = meta.get("ended") or {}
    begin, end = span(events, trace, meta.get("start", 0.0), ended.get("time"))
    pictures = _spread(list(recording.pictures()), _MOST_PICTURES)
    rows = lanes(events, trace, meta.get("robots", {}), end)
    changes, more_changes = _first(recording.changes(), _MOST_ROWS)
    sentences, more_sentences = _first(trace, _MOST_ROWS)
    return (
        _environment()
        .get_template("report.html.j2")
        .render(
            meta=meta,
            record=recording.path.name,
            complete=recording.complete,
            fault=ended.get("fault", ""),
            lasted=end - begin,
            wall=ended["wall"] - meta["wall"] if "wall" in ended and "wall" in meta else None,
            began=time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(meta["wall"])) if "wall" in meta else "",
            tasks=[_task(task) for task in recording.tasks],
            drawing=draw(rows, begin, end, [shot.time for shot in pictures]),
            lanes=rows,
            failures=[(lane, bar) for lane in rows for bar in lane.bars if bar.how == "bad"],
            trace=sentences,
            more_trace=more_sentences,
            changes=[_change(change) for change in changes],
            more_changes=more_changes,
            pictures=[
                (number, shot, f"data:image/webp;base64,{base64.b64encode(shot.data).decode()}")
                for number, shot in enumerate(pictures, 1)
            ],
            forgotten=recording.left_out,
        )
    )


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("skiros_py.recording"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        autoescape=True,
    )


def _task(task: Mapping[str, Any]) -> dict[str, Any]:
    report = task["report"]
    outcome = report["outcome"] if report else "not over"
    return {**task, "outcome": outcome, "kind": _KIND_OF_TASK.get(outcome, "bad")}


def _change(change: Any) -> dict[str, Any]:
    shown = list(describe(change.edits[:_MOST_EDITS]))
    left = len(change.edits[_MOST_EDITS:])
    return {"change": change, "writer": change.writer.value, "edits": shown + ([f"and {left} more"] if left else [])}


def _first(rows: Iterable[Any], most: int) -> tuple[list[Any], int]:
    """Returns the first rows, and how many others there are."""
    rest = iter(rows)
    return list(islice(rest, most)), sum(1 for _ in rest)


def _spread(pictures: Sequence[Picture], most: int) -> list[Picture]:
    """Returns at most so many pictures, evenly spread."""
    if len(pictures) <= most:
        return list(pictures)
    return [pictures[number * len(pictures) // most] for number in range(most)]
