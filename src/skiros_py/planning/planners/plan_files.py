"""Plan files as planners write them: one action per line, with times if the planner provides them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from skiros_py.errors import PlanningError
from skiros_py.planning.planners.planner import Solved

_STEP = re.compile(
    r"(?:(?P<start>\d+(?:\.\d+)?)\s*:\s*)?"  # 0.003:
    r"\(\s*(?P<words>[^()\s][^()]*)\)"  # (drive base_1 robot_1 box_a floor)
    r"(?:\s*\[\s*(?P<duration>\d+(?:\.\d+)?)[^\]]*\])?"  # [12.000]
)
_LONGEST = 16 << 20
"""Maximum size of a plan file [bytes]."""


def read_plan_text(title: str, text: str) -> Solved:
    """Reads a plan file.

    Args:
        title: What people call the planner.
        text: Lines such as ``(drive base_1 box_a)`` or ``0.000: (drive base_1 box_a) [5.000]``, and comments after
            semicolons.

    Raises:
        PlanningError: A line is not a step; or only some steps have a time.
    """
    found = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition(";")[0].strip()
        if not words:
            continue
        step = _STEP.fullmatch(words)
        if step is None:
            shown = words if len(words) <= 80 else words[:80] + "…"
            raise PlanningError(f"{title} wrote a plan whose line {number} is no step: '{shown}'")
        found.append(step)
    return _solved(title, found)


def read_plan_file(title: str, path: Path) -> Solved:
    """Reads a plan file; see :func:`read_plan_text`.

    Raises:
        PlanningError: It is not a plan, or cannot be read.
    """
    try:
        with path.open("rb") as file:
            content = file.read(_LONGEST + 1)
    except OSError as error:
        raise PlanningError(f"{title} wrote a plan that cannot be read: {error.strerror}") from error
    if len(content) > _LONGEST:
        raise PlanningError(f"{title} wrote a plan of more than {_LONGEST >> 20} MiB")
    return read_plan_text(title, content.decode("utf-8", errors="replace"))


def last_plan_file(folder: Path, pattern: str) -> Path | None:
    """Returns the plan file in a folder; the last, where a planner that improves its plans has numbered them."""
    found = [path for path in folder.glob(pattern) if path.is_file() and not path.is_symlink()]
    return max(found, key=lambda path: (len(path.name), path.name), default=None)


def steps_among(title: str, text: str) -> Solved | None:
    """Finds the steps in a planner's output; None if there are none."""
    found = [step for line in text.splitlines() if (step := _STEP.fullmatch(line.partition(";")[0].strip()))]
    return _solved(title, found) if found else None


def _solved(title: str, found: Iterable[re.Match[str]]) -> Solved:
    steps = list(found)
    timed = [step for step in steps if step["start"] is not None]
    if len(timed) not in (0, len(steps)):
        raise PlanningError(f"{title} wrote a plan in which {len(timed)} of {len(steps)} steps have a time")
    timed.sort(key=lambda step: float(step["start"]))
    return Solved(
        tuple(tuple(step["words"].lower().split()) for step in timed or steps),
        tuple(float(step["start"]) for step in timed),
        tuple(float(step["duration"] or 0.0) for step in timed),
    )
