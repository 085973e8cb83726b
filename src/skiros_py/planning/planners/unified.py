"""The bridge to unified-planning and its engines; and planners with one method that takes PDDL files.

It is called in a process of its own, for each task again. So it may take as long as it likes, use libraries that are
not made for threads, start programs or crash: it is stopped, and nothing of it is left running.

Importing it takes a second or two, and its engines leave files in the current folder: it runs in a process of its own.
"""

from __future__ import annotations

import pickle
import sys
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from skiros_py.errors import MissingExtra, PlanningError
from skiros_py.planning.planners import solving
from skiros_py.planning.planners.planner import Answer, Unsolvable
from skiros_py.planning.planners.program_planner import CLASSICAL, CommandLinePlanner, read_plan_text
from skiros_py.processes import packed
from skiros_py.programs import USUAL_LIMITS, Ended, Limits

_CALL, _REPLY = "call", "reply"
_STAYS = {"_threads"}


class FilesPlanner(CommandLinePlanner):
    """Base class of planners that solve PDDL files in Python; say ``name``, ``supports`` and :meth:`solve_files`.

    Args:
        limits: What each call may take.
    """

    supports = CLASSICAL

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
            folder: Where both are; the current folder, to work in. It is deleted afterwards.

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
        answer = pickle.loads(reply.read_bytes())  # noqa: S301 - our own program has written it
        if isinstance(answer, PlanningError):
            raise PlanningError(f"{self.title} broke: {answer}")
        return read_plan_text(self.title, answer) if isinstance(answer, str) else answer


_LIMITS = Limits(memory=None)


class UnifiedPlanning(FilesPlanner):
    """Solves tasks with an engine of unified-planning.

    Args:
        engine: Name of the engine ("fast-downward", "aries", "lpg", …); None for the first that fits the task.
        parameters: Its parameters.
        limits: Resource limits of each call. Engines in Java reserve more memory than they use: there is no limit.

    Raises:
        MissingExtra: It is not installed.
    """

    name = "unified-planning"
    supports = CLASSICAL | {
        ":adl", ":action-costs", ":fluents", ":durative-actions", ":duration-inequalities", ":timed-initial-literals",
    }  # fmt: skip

    def __init__(
        self,
        engine: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        limits: Limits = _LIMITS,
    ) -> None:
        if find_spec("unified_planning") is None:
            raise MissingExtra("planners", "unified-planning")
        super().__init__(limits)
        self.engine = engine
        self.parameters = dict(parameters or {})

    def solve_files(self, domain: Path, problem: Path, folder: Path) -> str | Unsolvable:  # noqa: ARG002 - the port's
        """Solves a task; called in a process of its own."""
        from unified_planning import exceptions
        from unified_planning.io import PDDLReader
        from unified_planning.shortcuts import OneshotPlanner, get_environment

        get_environment().credits_stream = None
        task = PDDLReader().parse_problem(str(domain), str(problem))
        by = {"name": self.engine} if self.engine else {"problem_kind": task.kind}
        try:
            planner = OneshotPlanner(**by, params=self.parameters)
        except exceptions.UPNoRequestedEngineAvailableException as error:
            known = ", ".join(get_environment().factory.engines)
            raise PlanningError(f"unified-planning has no engine '{self.engine}' here; it has {known}") from error
        except exceptions.UPNoSuitableEngineAvailableException as error:
            raise PlanningError(f"unified-planning has no engine for this task here: {error}") from error
        with planner:
            return _words(planner.solve(task))


def _words(result: Any) -> str | Unsolvable:
    """Writes the plan of a result.

    Raises:
        PlanningError: The engine failed.
    """
    status = result.status.name
    if status.startswith("UNSOLVABLE"):
        return Unsolvable(proven=status == "UNSOLVABLE_PROVEN")
    if result.plan is None:
        said = "; ".join(message.message for message in result.log_messages or ())
        raise PlanningError(f"engine '{result.engine_name}' answers {status}: {said[-1000:] or 'without a word'}")
    if hasattr(result.plan, "timed_actions"):
        return "\n".join(
            f"{float(start):.6f}: {_action(action)} [{float(duration or 0):.6f}]"
            for start, action, duration in result.plan.timed_actions
        )
    return "\n".join(map(_action, result.plan.actions))


def _action(instance: Any) -> str:
    return f"({' '.join([instance.action.name, *map(str, instance.actual_parameters)])})"
