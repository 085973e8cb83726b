"""Use cases: previews, which plan for a goal in the world at the time of the request, and execute nothing."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from skiros_py.api import previews as api
from skiros_py.api.goals import GoalOrder
from skiros_py.api.previews import AppliedRepair, PreviewPage, PreviewState
from skiros_py.errors import Busy, Refused, SkirosError, UnknownName
from skiros_py.messages import Message
from skiros_py.planning.plan import NoPlan, Plan, Repair
from skiros_py.planning.requests import Asked, PlanRequest
from skiros_py.planning.service import Planned, PlanningOptions
from skiros_py.skills.conditions import Condition
from skiros_py.station.jobs.orders import texts_of
from skiros_py.station.jobs.views import planned_steps
from skiros_py.station.requests import LIBRARY, Author, Service, addressed, find
from skiros_py.station.session import Session
from skiros_py.world.change import Writer

if TYPE_CHECKING:
    from skiros_py.station.station import Station

_AT_ONCE = 2
"""Maximum number of concurrent planners, each of which occupies a core."""
_KEPT = 100
_RETRY_AFTER = 5.0
_EACH, _TOGETHER = 1.0, 4.0
"""Time limits for trying repairs, of one planner and in total [s]."""


@dataclass
class _Preview:
    """A plan for one goal, which is not executed.

    Attributes:
        id: Its id.
        goal: The goal texts.
        conditions: The same as parsed conditions.
        world: Version of the world for which it is planned.
        asked: Time of the request [s since 1970].
        planning: The request for the plan.
        planned: The answer; None while there is none.
        fault: Why planning failed; empty if it did not.
        ended: Set when planning has ended.
    """

    id: str
    goal: tuple[str, ...]
    conditions: tuple[Condition, ...]
    world: int
    asked: float
    planning: Asked[Planned]
    planned: Planned | None = None
    fault: str = ""
    ended: threading.Event = field(default_factory=threading.Event)

    @property
    def outcome(self) -> Plan | NoPlan | None:
        """The plan, or why there is none; None without an answer."""
        return None if self.planned is None else self.planned.outcome

    @property
    def repairs(self) -> tuple[Repair, ...]:
        """The possible repairs."""
        return self.outcome.repairs if isinstance(self.outcome, NoPlan) else ()


class PreviewService(Service):
    """Plans goals from the current beliefs, and applies the repairs offered if there is no plan. Close it."""

    def __init__(self, station: Station) -> None:
        super().__init__(station)
        self._previews: OrderedDict[str, _Preview] = OrderedDict()
        self._guard = threading.Lock()
        self._last = 0
        self._closed = False

    def ask(self, order: GoalOrder) -> api.Preview:
        """Starts to plan for a goal, and returns immediately.

        Raises:
            UsageError: The goal cannot be parsed.
            Busy: Too many previews are being planned already.
        """
        session, goal = self._session, texts_of(order, self._station.document_store)
        conditions = session.parse(goal)
        capabilities = tuple(self._call(lambda session: session.tasks.capabilities))
        options = PlanningOptions("preview", session.options.temporal, _EACH, _TOGETHER, session.catalogue.absent)
        with self._guard:
            if self._closed or sum(not one.ended.is_set() for one in self._previews.values()) >= _AT_ONCE:
                raise Busy(
                    Message("{count} previews are being planned: ask again later", count=_AT_ONCE),
                    retry_after=_RETRY_AFTER,
                )
            self._last += 1
            request = PlanRequest(conditions, capabilities, options=options)
            version, now = session.world.version, time.time()
            preview = _Preview(str(self._last), goal, conditions, version, now, session.planning.ask(request))
            self._previews[preview.id] = preview
            over = [id_ for id_, one in self._previews.items() if one.ended.is_set()]
            for id_ in over[: max(0, len(self._previews) - _KEPT)]:
                del self._previews[id_]
        preview.planning.when_done(lambda asked: _answered(preview, asked))
        return _shown(preview)

    def all(self) -> PreviewPage:
        """Lists the previews kept, latest first."""
        with self._guard:
            return PreviewPage(items=tuple(map(_shown, reversed(self._previews.values()))))

    def get(self, id_: str, wait: float = 0.0) -> api.Preview:
        """Returns the plan with order and planned starts; or why there is none, and possible repairs.

        Args:
            id_: Id of the preview.
            wait: Maximum wait for the answer [s].

        Raises:
            NotFound: There is none with this id.
        """
        preview = self._find(id_)
        self._station.waiter.wait_for(preview.ended, wait)
        return _shown(preview)

    def apply_repair(self, id_: str, number: int, author: Author = LIBRARY) -> AppliedRepair:
        """Applies a repair to the world, as one transaction; the goal is not changed.

        Raises:
            NotFound: There is no such preview or repair.
            Refused: It does not change the world.
        """
        repairs = self._find(id_).repairs
        with addressed():
            if not 0 <= number < len(repairs):
                raise UnknownName("repair", str(number), map(str, range(len(repairs))), where=f"of preview {id_}")
        repair = repairs[number]
        if not repair.edits:
            raise Refused(
                "RepairNotApplicable",
                Message("'{text}' is no change of the world: see to it, or order otherwise", text=repair.text),
            )
        repair.apply(self._world, author.name, Writer.PERSON, author.holder)
        return AppliedRepair(text=repair.done, world=self._world.version)

    def open(self, session: Session) -> None:
        """Keeps the previews of a session until that is closed."""
        session.on_close(self._forget)

    def _forget(self) -> None:
        with self._guard:
            previews = tuple(self._previews.values())
            self._previews.clear()
        for preview in previews:
            preview.planning.cancel()

    def close(self) -> None:
        """Cancels planning; may be called twice."""
        self._closed = True
        self._forget()

    def _find(self, id_: str) -> _Preview:
        with self._guard:
            return find("preview", id_, self._previews)


def _answered(preview: _Preview, asked: Asked[Planned]) -> None:
    try:
        answer = asked.result()
        preview.world, preview.planned = answer.version, answer.value
    except SkirosError as error:
        preview.fault = str(error)
    preview.ended.set()


def _shown(preview: _Preview) -> api.Preview:
    planned, outcome = preview.planned, preview.outcome
    plan, none = (outcome, None) if isinstance(outcome, Plan) else (None, outcome)
    state = PreviewState.FAILED if preview.fault else PreviewState.PLANNING
    if outcome is not None:
        state = PreviewState.PLANNED if plan is not None else PreviewState.NO_PLAN
    return api.Preview.view_of(
        preview,
        state=state,
        conditions=tuple(map(str, preview.conditions)),
        wall=None if planned is None else planned.wall,
        planner="" if planned is None else planned.planner,
        steps=() if plan is None else planned_steps(plan),
        seconds=None if plan is None else plan.seconds,
        chance=None if plan is None else plan.chance,
        reasons=((preview.fault,) if preview.fault else ()) if none is None else none.reasons,
        causes=() if none is None else tuple(cause.as_json() for cause in none.causes),
        repairs=tuple(
            api.Repair(id=number, **repair.as_json(), applicable=bool(repair.edits))
            for number, repair in enumerate(preview.repairs)
        ),
        notes=() if planned is None else planned.notes,
    )
