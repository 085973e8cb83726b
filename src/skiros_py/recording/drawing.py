"""Where on the page the bars of a timeline go."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from skiros_py.recording.timeline import Bar, Lane

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
class Box:
    """A bar as it is drawn [px]; the label is cut to what fits on it."""

    bar: Bar
    x: float
    y: float
    width: float
    label: str


@dataclass(frozen=True, slots=True)
class Band:
    """A lane as it is drawn [px]."""

    lane: Lane
    y: float
    height: float
    boxes: tuple[Box, ...]


@dataclass(frozen=True, slots=True)
class Drawing:
    """A timeline as it is drawn [px].

    Attributes:
        width, height: Of the whole.
        left: Where the axis begins.
        row: Height of a bar.
        bands: The lanes.
        ticks: Place and run time [s] of each tick.
        marks: Place and number of each picture, from 1.
    """

    width: float
    height: float
    left: float
    row: float
    bands: tuple[Band, ...]
    ticks: tuple[tuple[float, str], ...]
    marks: tuple[tuple[float, int], ...]


def draw(lanes: Sequence[Lane], begin: float, end: float, pictures: Sequence[float]) -> Drawing:
    """Draws a timeline.

    Args:
        lanes: What is on it.
        begin: Run time at its left end [s].
        end: Run time at its right end [s].
        pictures: Run times of the pictures [s].
    """
    axis = min(max(_NARROWEST, (end - begin) * _PER_SECOND), _WIDEST)
    scale = axis / (end - begin)

    def place(time: float) -> float:
        return round(_MARGIN + (time - begin) * scale, 2)

    bands, y = [], _TOP
    for lane in lanes:
        boxes = tuple(_box(bar, place(bar.start), place(bar.end), y) for bar in lane.bars)
        bands.append(Band(lane, y, lane.rows * _ROW, boxes))
        y += lane.rows * _ROW + _GAP
    ticks = tuple((place(time), f"{time:g}") for time in _ticks(begin, end, _TICK / scale))
    marks = tuple((place(time), number) for number, time in enumerate(pictures, 1))
    return Drawing(_MARGIN + axis + 10.0, y + _TOP, _MARGIN, _ROW - 4.0, tuple(bands), ticks, marks)


def _box(bar: Bar, start: float, end: float, top: float) -> Box:
    width = max(end - start, 1.0)
    letters = int((width - 6.0) / _LETTER)
    label = bar.label if len(bar.label) <= letters else bar.label[: letters - 1] + "…" if letters > 2 else ""
    return Box(bar, start, top + bar.row * _ROW + 2.0, round(width, 2), label)


def _ticks(begin: float, end: float, least: float) -> list[float]:
    """Returns round times between two others, at least so far apart."""
    power = 10.0 ** math.floor(math.log10(least))
    step = next(power * factor for factor in (1, 2, 5, 10) if power * factor >= least)
    first = math.ceil(begin / step - 1e-9)
    return [round(number * step, 6) for number in range(first, math.floor(end / step + 1e-9) + 1)]
