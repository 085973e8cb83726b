"""The share of one task in the robots and things of the cell: what it asks for, has, and lends while it waits."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

from skiros_py.planning.plan import Step
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.reservations import in_hands, used_by


class Share:
    """What one task has of the cell.

    Args:
        who: Name of the task.
        context: World and reservations.
        skills: The available skills by name; extended as managers appear.

    Attributes:
        lent: True while the task waits for a person, who may be long in coming: others may use what stands, but for
            robots that have a thing of this task in their hands, lest somebody puts it down somewhere.
    """

    def __init__(self, who: str, context: TaskContext, skills: Mapping[str, SkillDescription]) -> None:
        self.lent = False
        self._who = who
        self._context = context
        self._reservations = context.reservations
        self._skills = skills

    def ask(self, steps: Sequence[Step]) -> None:
        """Asks for what the steps use that run or are to come; what they use no more is free for others."""
        self._reservations.request(self._who, self._used(steps))

    def granted(self, running: Collection[Step], *, going_on: bool) -> bool:
        """Returns whether no other task has, or wanted before, what was asked for; takes it if it is free now.

        Args:
            running: The steps that run; what they use is kept in any case.
            going_on: False while no step may start: then it takes nothing, and others need not wait for it. It has to
                ask again afterwards.
        """
        reservations, who = self._reservations, self._who
        if self.lent:
            own = in_hands(self._context.world, reservations.of(who))
            reservations.withdraw(who, self._used(running) | own)
        elif reservations.waits(who) and not going_on:
            reservations.withdraw(who, self._used(running))
        elif reservations.waits(who):
            return reservations.granted(who, self._used(running))
        return going_on and not self.lent

    @property
    def waits_for(self) -> tuple[str, ...]:
        """What keeps it from getting what it asked for: "robot_1 (kit 7)"."""
        return self._reservations.waits_for(self._who)

    def release(self, moving: Iterable[str], stands: Callable[[], bool]) -> None:
        """Gives back everything.

        Args:
            moving: What of it is free for others only when it stands.
            stands: Tells whether it does.
        """
        self._reservations.release(self._who, moving, stands)

    def _used(self, steps: Iterable[Step]) -> frozenset[str]:
        return used_by(tuple(steps), self._skills, self._context.world)
