"""Previews: plans for goals that are not executed, for the world at the time of the request."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field

from skiros_py.errors import Busy, SkirosError, UnknownName
from skiros_py.planning.plan import NoPlan, Plan, Repair
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.requests import Asked, PlanRequest
from skiros_py.planning.service import Planned, PlanningOptions
from skiros_py.skills.conditions import Condition
from skiros_py.station.session import Session

_AT_ONCE = 2
"""Maximum number of concurrent planners, each of which occupies a core."""
_KEPT = 100
_RETRY_AFTER = 5.0
_EACH, _TOGETHER = 1.0, 4.0
"""Time limits for trying repairs, of one planner and in total [s]."""


@dataclass
class Preview:
    """A plan for one goal, which is not executed.

    Attributes:
        id: Its id.
        goal: The goal texts.
        conditions: The same as parsed conditions.
        world: Version of the world for which it is planned.
        asked: Time of the request [s since 1970].
        planned: The answer; None while there is none.
        fault: Why planning failed; empty if it did not.
        ended: Set when planning has ended.
    """

    id: str
    goal: tuple[str, ...]
    conditions: tuple[Condition, ...]
    world: int
    asked: float
    planned: Planned | None = None
    fault: str = ""
    ended: threading.Event = field(default_factory=threading.Event)

    @property
    def plan(self) -> Plan | None:
        """The plan, if there is one."""
        outcome = None if self.planned is None else self.planned.outcome
        return outcome if isinstance(outcome, Plan) else None

    @property
    def no_plan(self) -> NoPlan | None:
        """Why there is no plan, if that is the answer."""
        outcome = None if self.planned is None else self.planned.outcome
        return outcome if isinstance(outcome, NoPlan) else None

    @property
    def repairs(self) -> tuple[Repair, ...]:
        """The possible repairs."""
        return () if self.no_plan is None else self.no_plan.repairs

    def repair(self, number: int) -> Repair:
        """Returns one of the repairs.

        Raises:
            UnknownName: There is none with this number.
        """
        if not 0 <= number < len(self.repairs):
            known = [str(index) for index in range(len(self.repairs))]
            raise UnknownName("repair", str(number), known, where=f"of preview {self.id}")
        return self.repairs[number]


class Previews:
    """The latest previews of a server. Close it."""

    def __init__(self) -> None:
        self._previews: OrderedDict[str, Preview] = OrderedDict()
        self._under_way: dict[str, Asked[Planned]] = {}
        self._guard = threading.Lock()
        self._last = 0
        self._closed = False

    def ask(self, session: Session, goal: tuple[str, ...], capabilities: Sequence[Capability]) -> Preview:
        """Starts to plan for a goal, and returns immediately.

        Args:
            session: The station for which it is planned.
            goal: Goal texts.
            capabilities: The capabilities of its robots.

        Raises:
            UsageError: The goal cannot be parsed.
            Busy: Too many previews are being planned already.
        """
        conditions = session.parse(goal)
        options = PlanningOptions("preview", session.options.temporal, _EACH, _TOGETHER)
        request = PlanRequest(conditions, tuple(capabilities), options=options)
        with self._guard:
            if self._closed or len(self._under_way) >= _AT_ONCE:
                raise Busy(f"{_AT_ONCE} previews are being planned: ask again later", retry_after=_RETRY_AFTER)
            self._last += 1
            preview = Preview(str(self._last), goal, conditions, session.world.version, time.time())
            asked = session.planning.ask(request)
            self._keep(preview)
            self._under_way[preview.id] = asked
        asked.when_done(lambda asked: self._answered(preview, asked))
        return preview

    def find(self, id_: str) -> Preview:
        """Returns a preview.

        Raises:
            UnknownName: There is none, or it is no longer kept.
        """
        with self._guard:
            if id_ not in self._previews:
                raise UnknownName("preview", id_, list(self._previews))
            return self._previews[id_]

    def all(self) -> tuple[Preview, ...]:
        """Returns the previews kept, latest first."""
        with self._guard:
            return tuple(reversed(self._previews.values()))

    def forget(self, session: Session) -> None:
        """Cancels planning and drops all previews, because the station has changed."""
        del session
        self._end()
        with self._guard:
            self._previews.clear()

    def close(self) -> None:
        """Cancels planning; may be called twice."""
        self._closed = True
        self._end()

    def _keep(self, preview: Preview) -> None:
        self._previews[preview.id] = preview
        over = [id_ for id_, one in self._previews.items() if one.ended.is_set()]
        for id_ in over[: max(0, len(self._previews) - _KEPT)]:
            del self._previews[id_]

    def _end(self) -> None:
        with self._guard:
            under_way = tuple(self._under_way.values())
        for asked in under_way:
            asked.cancel()

    def _answered(self, preview: Preview, asked: Asked[Planned]) -> None:
        try:
            answer = asked.result()
            preview.world, preview.planned = answer.version, answer.value
        except SkirosError as error:
            preview.fault = str(error)
        with self._guard:
            self._under_way.pop(preview.id, None)
        preview.ended.set()


def is_applicable(repair: Repair) -> bool:
    """Returns whether a repair contains changes of the world, not only of the goal."""
    return bool(repair.edits)
