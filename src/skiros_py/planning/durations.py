"""How long skills take: as robots learned from their runs, else as authors declare.

What is learned are elements of the learned concepts, so it lasts as long as the world does, is journalled, and can be
looked at and forgotten like everything that was taught.
"""

from __future__ import annotations

import statistics
from collections.abc import Mapping
from dataclasses import replace
from typing import Protocol

from skiros_py.planning.problem.task import PlanningTask
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.element import Value
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import APPLIES_TO, LEARNED_DURATION, OF_SKILL, RUN_TIMES
from skiros_py.world.world import World

KEPT = 15
"""How many runs of a skill are remembered, the last ones: their median is not moved by one that was held up."""


class Ran(Protocol):
    """What is known of a skill that ran."""

    @property
    def skill(self) -> str:
        """Its name."""
        ...

    @property
    def start(self) -> float:
        """When it started [s]."""
        ...

    @property
    def end(self) -> float:
        """When it ended [s]."""
        ...

    @property
    def reason(self) -> str:
        """Why it failed; empty when it worked."""
        ...

    @property
    def agent(self) -> str:
        """Id of the subsystem that did it."""
        ...


def observe(world: World, ran: Ran) -> None:
    """Learns from a run; nothing from one that failed, took no time, or whose agent is gone.

    Args:
        world: Takes what is learned.
        ran: The step of a plan that ran.
    """
    seconds = ran.end - ran.start
    if ran.reason or seconds <= 0.0 or not world.has(ran.agent):
        return
    class_ = world.element(ran.agent).type
    known = _lesson(world, ran.skill, class_)
    with world.transaction(author="task manager", reason=f"{ran.skill} took {seconds:.2f} s") as tx:
        if known is None:
            properties: dict[str, Value] = {OF_SKILL: ran.skill, APPLIES_TO: class_, RUN_TIMES: (seconds,)}
            tx.add(LEARNED_DURATION, f"{ran.skill} by {class_}", None, properties, learned=True)
        else:
            tx.set(known, RUN_TIMES, (*_times(world, known), seconds)[-KEPT:])


def duration_of(view: WorldView, skill: SkillDescription, agent_class: str) -> float | None:
    """Returns how long a skill takes [s] when an agent of a class does it, or None if unknown.

    Args:
        view: The world, with what was learned.
        skill: The skill.
        agent_class: Most specific class of the subsystem that does it.
    """
    known = _lesson(view, skill.name, agent_class)
    return skill.duration if known is None else statistics.median(_times(view, known))


def timed(view: WorldView, task: PlanningTask) -> PlanningTask:
    """Returns a task whose actions say how long they take: as long as the slowest kind of agent that is there needs."""
    seconds = {c.skill.name: _slowest(view, c.skill, c.agents) for c in task.capabilities}
    actions = tuple(replace(a, duration=seconds.get(a.skill)) if a.skill else a for a in task.domain.actions)
    return replace(task, domain=replace(task.domain, actions=actions))


def rates(view: WorldView, task: PlanningTask) -> dict[str, dict[str, float]]:
    """Returns how long each agent needs for each skill of a task [s], by skill and agent, as far as that is known."""
    known = ((c.skill, agent) for c in task.capabilities for agent in c.agents if view.has(agent))
    found: dict[str, dict[str, float]] = {}
    for skill, agent in known:
        seconds = duration_of(view, skill, view.element(agent).type)
        if seconds is not None:
            found.setdefault(skill.name, {})[agent] = seconds
    return found


def _slowest(view: WorldView, skill: SkillDescription, agents: tuple[str, ...]) -> float | None:
    classes = sorted({view.element(agent).type for agent in agents if view.has(agent)})
    known = [seconds for class_ in classes if (seconds := duration_of(view, skill, class_)) is not None]
    return max(known, default=skill.duration)


def _lesson(view: WorldView, skill: str, class_: str) -> str | None:
    """Returns the id of what was learned of a skill done by agents of a class, or None."""
    if LEARNED_DURATION not in view.ontology.classes:
        return None
    wanted: Mapping[str, object] = {OF_SKILL: skill, APPLIES_TO: class_}
    lessons = (view.element(lesson) for lesson in view.abstracts(LEARNED_DURATION))
    found = (e.id for e in lessons if all(e.properties.get(key) == value for key, value in wanted.items()))
    return next(found, None)


def _times(view: WorldView, lesson: str) -> tuple[float, ...]:
    value = view.element(lesson).properties.get(RUN_TIMES)
    return value if isinstance(value, tuple) else ()
