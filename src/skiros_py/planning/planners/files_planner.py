"""The shortest way to a custom planner: one method that takes PDDL files and returns the plan file's text.

It is called in a process of its own, for each task again. So it may take as long as it likes, use libraries that are
not made for threads, start programs or crash: it is stopped, and nothing of it is left running.
"""

from __future__ import annotations

import pickle
import sys
from abc import abstractmethod
from collections.abc import Sequence
from pathlib import Path

from skiros_py.errors import PlanningError
from skiros_py.planning.planners import solving
from skiros_py.planning.planners.plan_files import read_plan_text
from skiros_py.planning.planners.planner import Answer, Unsolvable
from skiros_py.planning.planners.program_planner import CommandLinePlanner
from skiros_py.planning.planners.programs import USUAL_LIMITS, Ended, Limits
from skiros_py.processes import packed

_CALL, _REPLY = "call", "reply"
_STAYS = {"_threads"}


class FilesPlanner(CommandLinePlanner):
    """Base class of planners that solve PDDL files in Python; say ``name``, ``supports`` and :meth:`solve_files`.

    Args:
        limits: What each call may take.
    """

    supports = frozenset({":strips", ":typing"})

    def __init__(self, limits: Limits = USUAL_LIMITS) -> None:
        self.title = f"planner '{self.name}'"
        super().__init__(limits)

    @abstractmethod
    def solve_files(self, domain: Path, problem: Path, folder: Path) -> str | Unsolvable:
        """Solves a task; called in a process of its own.

        Exceptions count as planner failures; their text is shown to the user.

        Args:
            domain: The domain file.
            problem: The problem file.
            folder: Where both are; the present folder, to work in. It is deleted afterwards.

        Returns:
            The plan as planners write it: one ``(action object …)`` a line, with times before and durations after where
            it knows them; or that there is none.
        """

    def command(self, domain: str, problem: str) -> Sequence[str]:
        """Returns the command line that calls the method."""
        return [sys.executable, "-m", solving.__name__, domain, problem, _CALL, _REPLY]

    def prepare(self, folder: Path) -> None:
        """Writes there the method to call and its module search path."""
        call = packed(self.solve_files)
        (folder / _CALL).write_bytes(pickle.dumps((sys.path, call)))

    def __getstate__(self) -> dict[str, object]:
        """Returns only the attributes of the author's class, without those that run calls."""
        return {name: value for name, value in vars(self).items() if name not in _STAYS}

    def read(self, ended: Ended, folder: Path) -> Answer:
        """Reads the reply."""
        reply = folder / _REPLY
        if ended.code != 0 or not reply.is_file():
            raise PlanningError(f"{self.title} {ended.words}")
        kind, _, text = reply.read_text(encoding="utf-8").partition("\n")
        match kind:
            case "plan":
                return read_plan_text(self.title, text)
            case "proven" | "unproven":
                return Unsolvable(text, proven=kind == "proven")
            case _:
                raise PlanningError(f"{self.title} broke: {text}")
