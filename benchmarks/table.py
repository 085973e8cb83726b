"""The output of every benchmark: a table of figures with their bars, and a summary in the last line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


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


def finish(title: str, figures: Sequence[Figure]) -> int:
    """Prints the table and the summary; returns the exit status: 0 only if all bars hold."""
    rows = [("figure", "measured", "bar", "compared with", "")]
    rows += [(f.what, f.value, f.bar, f.compared, "" if not f.bar else "ok" if f.holds else "MISSED") for f in figures]
    widths = [max(len(row[column]) for row in rows) for column in range(5)]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
    missed = [f.what for f in figures if not f.holds]
    summary = f"{len(missed)} of {len(figures)} bars missed: {', '.join(missed)}" if missed else "all bars hold"
    print(f"{title}: {summary}")
    return 1 if missed else 0
