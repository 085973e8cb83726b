"""One task's share of the cell's robots and things: what it requests, holds, and lends while it waits."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

from skiros_py.planning.plan import Step
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.reservations import in_hands, used_by


class Share:
    """The robots and things of one task.

    Args:
        who: Name of the task.
        context: World and reservations.
        skills: The available skills by name; extended as managers appear.

    Attributes:
        lent: True while the task waits for the user, which may take long: other tasks may use what is at rest, except
            robots that hold a thing of this task, so that it is not put down elsewhere.
    """

    def __init__(self, who: str, context: TaskContext, skills: Mapping[str, SkillDescription]) -> None:
        self.lent = False
        self._who = who
        self._context = context
        self._reservations = context.reservations
        self._skills = skills

    def ask(self, steps: Sequence[Step]) -> None:
        """Requests what running and remaining steps use; anything else becomes free for others."""
        self._reservations.request(self._who, self._used(steps))

    def granted(self, running: Collection[Step], *, going_on: bool) -> bool:
        """Returns whether no other task holds, or requested earlier, what this task requested; takes it if free now.

        Args:
            running: The running steps; what they use is always kept.
            going_on: False while no step may start: then it takes nothing and does not block others. It has to request
                again afterwards.
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
        """What its request is waiting for: "robot_1 (kit 7)"."""
        return self._reservations.waits_for(self._who)

    def release(self, moving: Iterable[str], stands: Callable[[], bool]) -> None:
        """Releases everything.

        Args:
            moving: Those elements that become free only once they are at rest.
            stands: Returns whether they are at rest.
        """
        self._reservations.release(self._who, moving, stands)

    def _used(self, steps: Iterable[Step]) -> frozenset[str]:
        return used_by(tuple(steps), self._skills, self._context.world)
