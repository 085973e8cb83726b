"""Kairos as a program: classical, temporal and numeric planning in milliseconds.

It comes with the ``kairos-planner`` package. As a separate program it can be killed, and its crashes do not affect
this process.
"""

from __future__ import annotations

import json
import shutil
import sysconfig
from collections.abc import Sequence
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path
from typing import Any

from skiros_py.errors import MissingExtra, PlanningError
from skiros_py.planning.planners.planner import Answer, Solved, Unsolvable
from skiros_py.planning.planners.program_planner import EVERYTHING, CommandLinePlanner
from skiros_py.programs import Ended, Limits

_SOLVED, _PROVED_UNSOLVABLE, _OUT_OF_TIME, _OUT_OF_MEMORY, _UNSUPPORTED, _NO_PLAN_FOUND = 0, 10, 11, 12, 13, 14
_PLAN = "plan"

OPTIONS = ("--no-anytime", "--threads", "1", "--seed", "0")
"""One thread, until the first plan."""


def program_path() -> Path:
    """Returns the path of the program.

    Raises:
        MissingExtra: It is not installed.
    """
    beside = Path(sysconfig.get_path("scripts")) / "kairos"
    if beside.is_file():
        return beside
    with suppress(PackageNotFoundError):
        for file in files("kairos-planner") or ():
            if file.name == "kairos" and (path := Path(str(file.locate()))).is_file():
                return path
    if found := shutil.which("kairos"):
        return Path(found)
    raise MissingExtra("planners", "Kairos")


class Kairos(CommandLinePlanner):
    """Runs Kairos on one thread until the first plan, so that its answer does not depend on the clock.

    Args:
        options: Arguments after the files.
        time_limit: Wall time after which a call is given up [s]; a guard, not a means of control.
        memory: Memory limit [bytes].

    Raises:
        MissingExtra: It is not installed.
    """

    name = "kairos"
    title = "Kairos"
    is_alone = True
    supports = EVERYTHING | {":time", ":timed-initial-fluents"}

    def __init__(
        self,
        options: tuple[str, ...] = OPTIONS,
        time_limit: float = 120.0,
        memory: int = 4 << 30,
    ) -> None:
        super().__init__(Limits(time_limit, memory))
        self._program = str(program_path())
        self._options = options

    def command(self, domain: str, problem: str) -> Sequence[str]:
        """Returns the command line for two files."""
        limits = ["--timeout", f"{self.limits.time:g}", "--memory", str((self.limits.memory or 0) >> 20)]
        return [self._program, domain, problem, "--format", "json", "--output", _PLAN, *limits, *self._options]

    def read(self, ended: Ended, folder: Path) -> Answer:
        """Reads the answer."""
        if ended.code in (_PROVED_UNSOLVABLE, _NO_PLAN_FOUND):
            return Unsolvable(proven=ended.code == _PROVED_UNSOLVABLE)
        if ended.code == _UNSUPPORTED:
            raise PlanningError(f"{self.title} cannot plan with something in the task; it {ended.words}")
        if ended.code != _SOLVED:
            raise self.failed(ended, out_of_time={_OUT_OF_TIME}, out_of_memory={_OUT_OF_MEMORY})
        return self._plan(folder / _PLAN)

    def _plan(self, path: Path) -> Solved:
        try:
            return _solved(json.loads(path.read_bytes()))
        except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
            raise PlanningError(f"{self.title} wrote a plan that cannot be read: {error}") from error


def _solved(found: dict[str, Any]) -> Solved:
    steps = sorted(found["steps"], key=lambda step: float(step["time"])) if found["temporal"] else found["steps"]
    times = steps if found["temporal"] else []
    return Solved(
        tuple(tuple(step["action"].strip("()").lower().split()) for step in steps),
        tuple(float(step["time"]) for step in times),
        tuple(float(step["duration"]) for step in times),
    )
