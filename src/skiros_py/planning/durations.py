"""Skill durations: learned from runs, otherwise as declared by the skill authors.

Learned durations are stored as elements of learned concepts: they persist with the world, are journalled, and can be
inspected and deleted like all taught data.
"""

from __future__ import annotations

import statistics
from dataclasses import replace

from skiros_py.messages import Message
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.element import Value
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import APPLIES_TO, LEARNED_DURATION, OF_SKILL, RUN_TIMES
from skiros_py.world.world import World

KEPT = 15
"""How many recent runs of a skill are kept; their median is robust against single delays."""


def observe(world: World, skill: str, agent: str, seconds: float) -> None:
    """Learns from a successful run; ignores runs that took no time, or whose agent is gone.

    Args:
        world: Stores the learned duration.
        skill: Name of the skill.
        agent: Id of the subsystem that ran it.
        seconds: How long it took [s].
    """
    if seconds <= 0.0 or not world.has(agent):
        return
    class_ = world.element(agent).type
    known = _lesson(world, skill, class_)
    with world.transaction(
        author="task manager", reason=Message("{skill} took {seconds:.2f} s", skill=skill, seconds=seconds)
    ) as tx:
        if known is None:
            properties: dict[str, Value] = {OF_SKILL: skill, APPLIES_TO: class_, RUN_TIMES: (seconds,)}
            tx.add(LEARNED_DURATION, f"{skill} by {class_}", None, properties, learned=True)
        else:
            tx.set(known, RUN_TIMES, (*_times(world, known), seconds)[-KEPT:])


def duration_of(view: WorldView, skill: SkillDescription, agent_class: str) -> float | None:
    """Returns how long a skill takes [s] when an agent of a class does it, or None if unknown.

    Args:
        view: The world, with the learned durations.
        skill: The skill.
        agent_class: Most specific class of the subsystem that runs it.
    """
    known = _lesson(view, skill.name, agent_class)
    return skill.duration if known is None else statistics.median(_times(view, known))


def timed(task: PlanningTask) -> PlanningTask:
    """Returns the task with durations of its actions: those of the slowest kind of agent present."""
    seconds = {c.skill.name: _slowest(task.view, c.skill, c.agents) for c in task.capabilities}
    actions = tuple(replace(a, duration=seconds.get(a.skill)) if a.skill else a for a in task.domain.actions)
    return replace(task, domain=replace(task.domain, actions=actions))


def _slowest(view: WorldView, skill: SkillDescription, agents: tuple[str, ...]) -> float | None:
    classes = sorted({view.element(agent).type for agent in agents if view.has(agent)})
    known = [seconds for class_ in classes if (seconds := duration_of(view, skill, class_)) is not None]
    return max(known, default=skill.duration)


def _lesson(view: WorldView, skill: str, class_: str) -> str | None:
    """Returns the id of the learned duration of a skill for agents of a class, or None."""
    if LEARNED_DURATION not in view.ontology.classes:
        return None
    lessons = {lesson: view.element(lesson).properties for lesson in view.abstracts(LEARNED_DURATION)}
    found = (name for name, own in lessons.items() if (own.get(OF_SKILL), own.get(APPLIES_TO)) == (skill, class_))
    return next(found, None)


def _times(view: WorldView, lesson: str) -> tuple[float, ...]:
    value = view.element(lesson).properties.get(RUN_TIMES)
    return value if isinstance(value, tuple) else ()
