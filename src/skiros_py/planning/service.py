"""Planning as one call: task, PDDL, planner, replay, explanation."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass

from skiros_py.planning.explanation import explain
from skiros_py.planning.needs import passed_keys
from skiros_py.planning.pddl import PddlTexts, write_pddl
from skiros_py.planning.plan import NoPlan, Plan, Step, read_plan
from skiros_py.planning.planner import Answer, Planner, Unsolvable
from skiros_py.planning.regrounding import pddl_plan
from skiros_py.planning.task import Capability, PlanningTask, build_task
from skiros_py.planning.validation import replay
from skiros_py.skills.conditions import Condition
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.view import WorldView

__all__ = ["Planned", "PlanningService"]


@dataclass(frozen=True, slots=True)
class Planned:
    """A planning result with everything it was made from.

    Attributes:
        outcome: The plan, or why there is none.
        texts: Domain and problem as given to the planner; None where none had to be asked.
        wall: Wall time from world model to replayed plan [s].
    """

    outcome: Plan | NoPlan
    texts: PddlTexts | None
    wall: float


class PlanningService:
    """Plans with one planner; the world given is never changed.

    Args:
        planner: What solves the PDDL.
        name: Name of domain and problem.
        lockstep: True when simulated time stands still while the planner works.
        waiting: Says, for as long as it is entered, that a long wait for the planner is no fault.
    """

    def __init__(
        self,
        planner: Planner,
        name: str = "skiros",
        *,
        lockstep: bool = True,
        waiting: Callable[[], AbstractContextManager[None]] = nullcontext,
    ) -> None:
        self.planner = planner
        self._name = name
        self._lockstep = lockstep
        self._waiting = waiting

    def plan(
        self, view: WorldView, capabilities: Sequence[Capability], goal: Sequence[Condition]
    ) -> Generator[None, None, Planned]:
        """Plans; yields while the planner works, unless in lockstep.

        Raises:
            PlanningError: The task cannot be written, the planner broke, or its answer is no plan.
        """
        started = time.perf_counter()
        gone = sorted({a for c in goal for a in c.arguments if a not in view.ontology.classes and not view.has(a)})
        if gone:
            return Planned(NoPlan(tuple(f"there is no {name} any more" for name in gone)), None, 0.0)
        task = build_task(view, capabilities, goal)
        texts = write_pddl(task.domain, task.problem, name=self._name)
        pending = self.planner.solve(texts.domain, texts.problem)
        while not (self._lockstep or pending.done()):
            yield
        with self._waiting():
            answer = pending.result()
        outcome = self._outcome(view, task, texts, answer)
        return Planned(outcome, texts, time.perf_counter() - started)

    def _outcome(self, view: WorldView, task: PlanningTask, texts: PddlTexts, answer: Answer) -> Plan | NoPlan:
        if isinstance(answer, Unsolvable):
            reasons = explain(task, view)
            return NoPlan(reasons or (_conflict(task.conditions),))
        skills = {c.skill.name: c.skill for c in task.capabilities}
        keys = {name: passed_keys(skill) for name, skill in skills.items()}
        steps = read_plan(answer.steps, texts, keys)
        flaw = replay(view, steps, task.conditions, skills)
        if flaw is not None:
            where = f"step {flaw.step + 1} ({steps[flaw.step]})" if flaw.step is not None else "the end"
            return NoPlan((f"the plan of {self.planner.name} breaks at {where}: {flaw.verdict.text}",))
        steps = _without_detours(view, steps, task, skills)
        return Plan(steps, pddl_plan(task, texts, steps, view.ontology))


def _conflict(goal: Sequence[Condition]) -> str:
    """Says why there is no plan although nothing is lacking that skills could not bring about."""
    if len(goal) > 1:
        return "each condition could be reached alone, but not all of them together"
    return f"{goal[0]} cannot be reached: whatever is done for it undoes something else that it needs"


def _without_detours(
    view: WorldView, steps: tuple[Step, ...], task: PlanningTask, skills: Mapping[str, SkillDescription]
) -> tuple[Step, ...]:
    """Leaves out steps without which the plan still survives the replay (a satisficing planner may wander)."""
    for index in reversed(range(len(steps))):
        shorter = steps[:index] + steps[index + 1 :]
        if replay(view, shorter, task.conditions, skills) is None:
            steps = shorter
    return steps
