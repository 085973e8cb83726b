"""The output of every benchmark: a table of figures with their bars, and a summary in the last line.

A bar on a time is a ratio to something measured in the same run: a peer, the bare engine or program, or, where there is
no such thing, the step of a plain Python loop (:func:`in_steps`). Simulated times, memory and counts are absolute.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class Figure:
    """One measured figure.

    Attributes:
        what: What was measured.
        value: The figure, printed.
        bar: What it is held against, printed; empty where there is no bar.
        holds: Whether the bar holds.
        compared: What it is compared with in the same run.
    """

    what: str
    value: str
    bar: str = ""
    holds: bool = True
    compared: str = ""


_STEPS = 20_000


def seconds_per_step() -> float:
    """Returns the time of one step of a plain Python loop on this machine, now [s]: best of five loops.

    A step formats a key, and reads and writes a dictionary. It took 0.18 µs where the bars were set.
    """
    return min(_loop() for _ in range(5)) / _STEPS


def _loop() -> float:
    sums: dict[str, int] = {}
    started = time.perf_counter()
    for number in range(_STEPS):
        key = f"part_{number % 1000}"
        sums[key] = sums.get(key, 0) + number
    return time.perf_counter() - started


def in_steps(what: str, seconds: float, most: float, compared: str = "") -> Figure:
    """Returns the figure of a time whose bar is a number of steps of a plain Python loop, measured now.

    Args:
        what: What was measured.
        seconds: The measured time [s].
        most: The largest number of steps that it may take.
        compared: What else it is compared with.
    """
    step = seconds_per_step()
    steps = seconds / step
    beside = f"a step of a plain loop {step * 1e6:.2f} µs" + (f"; {compared}" if compared else "")
    return Figure(what, f"{duration(seconds)} = {steps:,.0f} steps", f"<= {most:,.0f} steps", steps <= most, beside)


def duration(seconds: float) -> str:
    """Returns a time for people, with three digits."""
    for unit, factor in (("s", 1.0), ("ms", 1e3)):
        if seconds * factor >= 1.0:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e6:.3g} µs"


def finish(title: str, figures: Sequence[Figure]) -> int:
    """Prints the table and the summary; returns the exit status: 0 only if all bars hold."""
    rows = [("figure", "measured", "bar", "compared with", "")]
    _print([*rows, *((f.what, f.value, f.bar, f.compared, _verdict(f)) for f in figures)])
    return _summarise(title, figures)


def finish_side_by_side(title: str, measured: Mapping[str, Sequence[Figure]]) -> int:
    """Prints the same figures of several things in a column each, and the summary; returns the exit status."""
    rows: list[tuple[str, ...]] = [("figure", "bar", *measured)]
    for figures in zip(*measured.values(), strict=True):
        cells = (f"{figure.value}  {_verdict(figure)}".rstrip() for figure in figures)
        rows.append((figures[0].what, figures[0].bar, *cells))
    _print(rows)
    named = [replace(figure, what=f"{name}: {figure.what}") for name, some in measured.items() for figure in some]
    return _summarise(title, named)


def _verdict(figure: Figure) -> str:
    return "" if not figure.bar else "ok" if figure.holds else "MISSED"


def _print(rows: Sequence[Sequence[str]]) -> None:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())


def _summarise(title: str, figures: Sequence[Figure]) -> int:
    missed = [f.what for f in figures if not f.holds]
    summary = f"{len(missed)} of {len(figures)} bars missed: {', '.join(missed)}" if missed else "all bars hold"
    print(f"{title}: {summary}")
    return 1 if missed else 0
