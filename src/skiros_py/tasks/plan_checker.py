"""Looks whether what is left of a plan still leads to the goal: again only when something changed that this read."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence

from skiros_py.execution.contained import contained
from skiros_py.planning.domain.needs import with_defaults
from skiros_py.planning.plan import Step
from skiros_py.planning.problem.stock import tokens_of, with_stock
from skiros_py.planning.sequence import Round
from skiros_py.planning.validation import Flaw, apply_effects, replay
from skiros_py.skills.conditions import Condition, Verdict
from skiros_py.skills.conditions.reads import Key, ReadingView, touched_by
from skiros_py.skills.outcome import Failure
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.change import Change
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView
from skiros_py.world.world import World

__all__ = ["PlanChecker", "supposing"]


class PlanChecker:
    """Replays what is left of one plan on the live world. It is used by one thread; any may write the world.

    Args:
        world: The live world model.
        goal: What the plan shall lead to.
        skills: The skills there are, by name.
    """

    def __init__(self, world: World, goal: Sequence[Condition], skills: Mapping[str, SkillDescription]) -> None:
        self._world = world
        self._goal = goal
        self._skills = skills
        self._keys: frozenset[Key] = frozenset()
        self._stale = True
        self._heard = world.version
        self._guard = threading.Lock()
        self._unsubscribe = world.subscribe(self._hear)

    @property
    def stale(self) -> bool:
        """True when something may be different from what the last look found."""
        return self._stale

    def look(
        self, running: Sequence[Step], rest: Sequence[Step], reached: Mapping[str, int] | None = None
    ) -> Flaw | None:
        """Tells what keeps the rest of the plan from leading to the goal, given that what runs will succeed.

        When nobody can tell, it does not lead there.

        Args:
            running: The steps that run.
            rest: The steps that have not started, in order.
            reached: The highest sequence number that each robot has visited in this task.
        """
        version, state = self._world.state()
        view = ReadingView(state, self._world.sensors)
        self._stale = False
        found = contained("the replay", lambda: self._replay(view, running, rest, reached))
        with self._guard:
            self._keys = frozenset(view.keys)
            self._stale = self._stale or self._heard > version
        return Flaw(None, Verdict(False, found.reason)) if isinstance(found, Failure) else found

    def close(self) -> None:
        """Hears of no more changes."""
        self._unsubscribe()

    def _replay(
        self, view: WorldView, running: Sequence[Step], rest: Sequence[Step], reached: Mapping[str, int] | None
    ) -> Flaw | None:
        stocked = with_stock(view, self._goal, tokens_of(rest))
        for index, step in enumerate(rest):
            gone = [name for name in tokens_of((step,)) if not stocked.has(name)]
            if gone:
                return Flaw(index, Verdict(False, f"nothing is left in stock for {gone[0]}"))
        overlay, visited = supposing(stocked, running, self._skills, reached)
        return replay(overlay, rest, self._goal, self._skills, reached=visited)

    def _hear(self, change: Change) -> None:
        """Called by whoever wrote, so it does no more than to compare."""
        with self._guard:
            self._heard = change.number
            touched = (key for edit in change.edits for key in touched_by(edit, self._world.ontology))
            self._stale = self._stale or any(key in self._keys for key in touched)


def supposing(
    view: WorldView,
    steps: Sequence[Step],
    skills: Mapping[str, SkillDescription],
    reached: Mapping[str, int] | None = None,
) -> tuple[Overlay, Mapping[str, int]]:
    """Returns the world as it will be when some steps that run have ended well.

    Args:
        view: The world now.
        steps: What runs.
        skills: The skills there are, by name.
        reached: The highest sequence number that each robot has visited in this task; returned as it will be.
    """
    overlay, round_ = Overlay(view), Round(view, (), reached)
    for step in steps:
        skill = skills[step.skill]
        values = with_defaults(skill, step.arguments)
        round_.take(overlay, skill, values)
        apply_effects(overlay, skill.post, values)
    return overlay, round_.reached
