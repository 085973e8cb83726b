"""The bridge to unified-planning and the engines that are installed for it.

Importing it takes a second or two, and its engines leave files in the present folder: it runs in a process of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from skiros_py.errors import PlanningError
from skiros_py.planning.planners.files_planner import FilesPlanner
from skiros_py.planning.planners.planner import Unsolvable
from skiros_py.planning.planners.programs import Limits

_LIMITS = Limits(memory=None)


class UnifiedPlanning(FilesPlanner):
    """Solves tasks with an engine of unified-planning.

    Args:
        engine: Name of the engine ("fast-downward", "aries", "lpg", …); None for the first that fits the task.
        parameters: Its parameters.
        limits: Resource limits of each call. Engines in Java reserve more memory than they use: there is no limit.
    """

    name = "unified-planning"
    supports = frozenset(
        {
            ":strips", ":typing", ":equality", ":negative-preconditions", ":disjunctive-preconditions",
            ":existential-preconditions", ":universal-preconditions", ":quantified-preconditions",
            ":conditional-effects", ":adl", ":action-costs", ":numeric-fluents", ":fluents", ":durative-actions",
            ":duration-inequalities", ":timed-initial-literals",
        }
    )  # fmt: skip

    def __init__(
        self,
        engine: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        limits: Limits = _LIMITS,
    ) -> None:
        super().__init__(limits)
        self.engine = engine
        self.parameters = dict(parameters or {})

    def solve_files(self, domain: Path, problem: Path, folder: Path) -> str | Unsolvable:  # noqa: ARG002 - the port's
        """Solves a task; called in a process of its own."""
        try:
            from unified_planning import exceptions
            from unified_planning.io import PDDLReader
            from unified_planning.shortcuts import OneshotPlanner, get_environment
        except ImportError as error:
            raise PlanningError(f"{error}: pip install unified-planning") from error
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
