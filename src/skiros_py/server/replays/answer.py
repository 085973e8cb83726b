"""A replay as it is answered: the kept texts put together, none of them read in one piece for longer than a cycle."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skiros_py.geometry import Array
from skiros_py.records.frames import Layout, decode_block
from skiros_py.server.replays.lines import Kind, Line
from skiros_py.server.replays.recording import MOST_FRAMES

__all__ = ["replay_text"]

_GAP = 1.0
"""Between what was before a restart and what came after it [s]."""
_CHUNK = 250
"""Moments that are turned into text at once."""
_DIGITS = 5


@dataclass(slots=True)
class _Part:
    """What lies between a beginning and the next."""

    head: Mapping[str, Any]
    layout: Layout
    view: bytes = b"{}"
    shift: float = 0.0
    ended: bool = False
    times: list[Array] = field(default_factory=list)
    rows: list[Array] = field(default_factory=list)
    changes: list[bytes] = field(default_factory=list)
    end: float = 0.0


def replay_text(lines: Iterable[Line], *, over: bool) -> bytes:
    """Puts a replay together as JSON.

    Args:
        lines: What was kept.
        over: Whether the job is over.

    Raises:
        ValueError: There is no beginning in it.
    """
    parts, full = _parts(lines)
    if not parts:
        raise ValueError("it has no beginning")
    runs = {part.head["run"] for part in parts}
    whole = over and not full and len(runs) == 1 and all(part.ended for part in parts)
    first = parts[0]
    head = {
        "job": first.head["job"],
        "start": first.head["time"],
        "end": parts[-1].end,
        "complete": whole,
        "shifts": [[_start(part), part.shift] for before, part in pairwise(parts) if part.shift != before.shift],
    }
    pieces = [
        json.dumps(head).encode()[:-1],
        b',"beginning":',
        first.view,
        b',"frames":',
        _frames(parts),
        b',"changes":[',
        b",".join(_changes(parts)),
        b"]}",
    ]
    return b"".join(pieces)


# ---------------------------------------------------------------------- reading


def _parts(lines: Iterable[Line]) -> tuple[list[_Part], bool]:
    """Returns the parts, the later ones shifted where run time has begun anew; and whether something was too much."""
    parts: list[_Part] = []
    full = False
    for kind, text in lines:
        if kind is Kind.BEGINNING:
            parts.append(_begun(json.loads(text), parts[-1] if parts else None))
        elif parts:
            _add(parts[-1], kind, text)
        full = full or kind is Kind.FULL
    return parts, full


def _begun(head: Mapping[str, Any], before: _Part | None) -> _Part:
    part = _Part(head, Layout.from_json(head["layout"]))
    if before is not None:
        anew = head["run"] != before.head["run"]
        part.shift = max(0.0, before.end + _GAP - head["time"]) if anew else before.shift
    part.end = _start(part)
    return part


def _add(part: _Part, kind: Kind, text: bytes) -> None:
    match kind:
        case Kind.VIEW:
            part.view = text
        case Kind.FRAMES:
            times, rows = decode_block(base64.b64decode(text))
            part.times.append(times + part.shift)
            part.rows.append(rows)
            part.end = max(part.end, float(part.times[-1][-1]))
        case Kind.CHANGE:
            change = json.loads(text)
            time = change["time"] + part.shift
            part.end = max(part.end, time)
            part.changes.append(text if not part.shift else json.dumps(change | {"time": time}).encode())
        case Kind.END:
            part.ended = True
            part.end = max(part.end, json.loads(text)["time"] + part.shift)


def _start(part: _Part) -> float:
    return float(part.head["time"]) + part.shift


# ---------------------------------------------------------------------- telling


def _changes(parts: list[_Part]) -> Iterable[bytes]:
    """Yields the changes, and where another part begins the whole view: much may be different by then."""
    for number, part in enumerate(parts):
        if number:
            yield f'{{"time":{_start(part)},"author":"","anew":true,"view":'.encode() + part.view + b"}"
        yield from part.changes


def _frames(parts: list[_Part]) -> bytes:
    """Returns the frames of all parts, for the devices of the first: thinned out where they are very many."""
    layout = parts[0].layout
    times, rows = _joined(parts)
    kept = _thinned(times)
    times, rows = times[kept], rows[kept]
    columns = _columns(layout)
    arms = {name: rows[:, columns["arm", name]] for name, _ in layout.arms}
    grippers = {name: rows[:, columns["gripper", name]][:, 0] for name in layout.grippers}
    bases = {name: rows[:, columns["base", name]] for name in layout.bases}
    members = [b'"times":' + _numbers(times)]
    for key, devices in (("arms", arms), ("grippers", grippers), ("bases", bases)):
        told = [json.dumps(name).encode() + b":" + _numbers(numbers) for name, numbers in devices.items()]
        members.append(json.dumps(key).encode() + b":{" + b",".join(told) + b"}")
    return b"{" + b",".join(members) + b"}"


def _joined(parts: list[_Part]) -> tuple[Array, Array]:
    """Returns times and rows of all parts; a device that a later part has no more stays where it was."""
    columns = _columns(parts[0].layout)
    width = sum(place.stop - place.start for place in columns.values())
    times = [time for part in parts for time in part.times]
    tables = [np.empty((0, width))]
    for part in parts:
        own = _columns(part.layout)
        for rows in part.rows:
            before = tables[-1][-1] if len(tables[-1]) else np.zeros(width)
            table = np.tile(before, (len(rows), 1))
            for key, place in columns.items():
                if key in own and own[key].stop - own[key].start == place.stop - place.start:
                    table[:, place] = rows[:, own[key]]
            tables.append(table)
    return np.concatenate([np.empty(0), *times]), np.concatenate(tables)


def _columns(layout: Layout) -> dict[tuple[str, str], slice]:
    """Returns which numbers of a row belong to which device."""
    widths = [(("arm", name), count) for name, count in layout.arms]
    widths += [(("gripper", name), 1) for name in layout.grippers]
    widths += [(("base", name), 3) for name in layout.bases]
    columns, start = {}, 0
    for key, width in widths:
        columns[key] = slice(start, start + width)
        start += width
    return columns


def _thinned(times: Array) -> NDArray[np.int_]:
    """Returns which frames to tell: none that are closer to the one before than what leaves room for all."""
    kept = np.arange(len(times))
    interval = 0.1
    while len(kept) > MOST_FRAMES:
        interval *= 2.0
        kept = kept[np.diff(np.floor(times[kept] / interval), prepend=-math.inf) > 0]
    return kept


def _numbers(values: Array) -> bytes:
    """Writes numbers, or rows of them, as JSON."""
    chunks = (values[start : start + _CHUNK] for start in range(0, len(values), _CHUNK))
    return b"[" + b",".join(json.dumps(np.round(chunk, _DIGITS).tolist())[1:-1].encode() for chunk in chunks) + b"]"
