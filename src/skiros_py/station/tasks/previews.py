"""Previews: goals that are planned and not done, each in a thread of its own over the world as it was just then."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, field

from skiros_py.errors import Busy, PlanningError, SkirosError, UnknownName
from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.planning.planners.choosing import Planners
from skiros_py.planning.planners.command import EVERYTHING, CommandPlanner
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.reasons import Repair
from skiros_py.planning.service import Planned, PlanningService
from skiros_py.skills.conditions import Condition
from skiros_py.station.session import Options, Session
from skiros_py.world.index import Index

__all__ = ["Preview", "Previews", "is_applicable"]

_AT_ONCE = 2
"""Planners take a core each."""
_KEPT = 100
_PAUSE = 0.0005
"""Time between two pieces of work: others want the interpreter too [s]."""
_RETRY_AFTER = 5.0


@dataclass
class Preview:
    """One goal that is planned and not done.

    Attributes:
        id: Its id.
        goal: Its texts.
        conditions: The same, as they were understood.
        world: Version of the world for which it is planned.
        view: That world; None when the work is over.
        asked: When it was asked for [s since 1970].
        planned: The answer; None while there is none.
        fault: Why there is none and will be none; empty in good times.
        unwanted: True when nobody wants the answer any more.
        ended: Set when there will be no other answer.
    """

    id: str
    goal: tuple[str, ...]
    conditions: tuple[Condition, ...]
    world: int
    view: Index | None
    asked: float
    planned: Planned | None = None
    fault: str = ""
    unwanted: bool = False
    ended: threading.Event = field(default_factory=threading.Event)

    @property
    def plan(self) -> Plan | None:
        """The plan, where there is one."""
        outcome = None if self.planned is None else self.planned.outcome
        return outcome if isinstance(outcome, Plan) else None

    @property
    def no_plan(self) -> NoPlan | None:
        """Why there is no plan, where that is the answer."""
        outcome = None if self.planned is None else self.planned.outcome
        return outcome if isinstance(outcome, NoPlan) else None

    @property
    def repairs(self) -> tuple[Repair, ...]:
        """What would help."""
        return () if self.no_plan is None else self.no_plan.repairs

    def repair(self, number: int) -> Repair:
        """Returns one of the repairs.

        Raises:
            UnknownName: There is none of that number.
        """
        if not 0 <= number < len(self.repairs):
            known = [str(index) for index in range(len(self.repairs))]
            raise UnknownName("repair", str(number), known, where=f"of preview {self.id}")
        return self.repairs[number]


class Previews:
    """The previews of a server, the last of them. Close it."""

    def __init__(self) -> None:
        self._previews: OrderedDict[str, Preview] = OrderedDict()
        self._guard = threading.Lock()
        self._threads: set[threading.Thread] = set()
        self._last = 0
        self._closed = False

    def ask(self, session: Session, goal: tuple[str, ...], capabilities: Sequence[Capability]) -> Preview:
        """Begins to plan for a goal, and returns at once.

        Args:
            session: The station for which it is planned.
            goal: Goal texts.
            capabilities: What its robots can do.

        Raises:
            UsageError: The goal cannot be understood.
            Busy: Enough is being planned already.
        """
        version, view = session.world.state()
        conditions = session.parse(goal)
        with self._guard:
            if self._closed or len(self._threads) >= _AT_ONCE:
                raise Busy(f"{_AT_ONCE} previews are being planned: ask again later", retry_after=_RETRY_AFTER)
            self._last += 1
            preview = Preview(str(self._last), goal, conditions, version, view, time.time())
            self._keep(preview)
            thread = threading.Thread(
                target=self._work, args=(preview, session, tuple(capabilities)), name=f"skiros-preview-{preview.id}"
            )
            self._threads.add(thread)
            thread.start()
        return preview

    def find(self, id_: str) -> Preview:
        """Returns a preview.

        Raises:
            UnknownName: There is none, or it is kept no longer.
        """
        with self._guard:
            if id_ not in self._previews:
                raise UnknownName("preview", id_, list(self._previews))
            return self._previews[id_]

    def all(self) -> tuple[Preview, ...]:
        """Returns those that are kept, the latest first."""
        with self._guard:
            return tuple(reversed(self._previews.values()))

    def forget(self, session: Session) -> None:
        """Ends what is being planned and forgets all: the station is another one from now on."""
        del session
        self._end()
        with self._guard:
            self._previews.clear()

    def close(self) -> None:
        """Ends what is being planned, and waits for that; may be called twice."""
        self._closed = True
        self._end()

    def _keep(self, preview: Preview) -> None:
        self._previews[preview.id] = preview
        over = [id_ for id_, one in self._previews.items() if one.ended.is_set()]
        for id_ in over[: max(0, len(self._previews) - _KEPT)]:
            del self._previews[id_]

    def _end(self) -> None:
        with self._guard:
            threads = tuple(self._threads)
            for preview in self._previews.values():
                preview.unwanted = True
        for thread in threads:
            thread.join()

    # ------------------------------------------------------------------ in a thread of its own

    def _work(self, preview: Preview, session: Session, capabilities: Sequence[Capability]) -> None:
        try:
            with closing(_planners(session)) as planners:
                preview.planned = _planned(preview, planners, session.options, capabilities)
        except SkirosError as error:
            preview.fault = str(error)
        except Exception as error:  # noqa: BLE001 - a plug-in's condition may raise anything; it is said, not hidden
            preview.fault = f"planning broke: {type(error).__name__}: {error}"
        finally:
            preview.view = None
            with self._guard:
                self._threads.discard(threading.current_thread())
            preview.ended.set()


def _planned(preview: Preview, planners: Planners, options: Options, capabilities: Sequence[Capability]) -> Planned:
    """Plans, until the answer is there or nobody wants it any more.

    Raises:
        PlanningError: The planners broke, or nobody wants it any more.
    """
    assert preview.view is not None  # until the work is over
    service = PlanningService(planners, "preview", lockstep=False, temporal=options.temporal)
    with closing(service.plan(preview.view, capabilities, preview.conditions)) as work:
        while not preview.unwanted:
            try:
                next(work)
            except StopIteration as end:
                planned: Planned = end.value
                return planned
            time.sleep(_PAUSE)
    raise PlanningError("planning was stopped: the station ends, or another scene is loaded")


def is_applicable(repair: Repair) -> bool:
    """Tells whether there is anything of a repair to be made in the world; what it changes in the goal is not."""
    return bool(repair.edits)


def _planners(session: Session) -> Planners:
    """Makes planners of our own: those of the station may be at work."""
    options = session.options
    if options.planner_command is not None:
        return Planners.only(CommandPlanner("command", options.planner_command, supports=EVERYTHING))
    return session.catalogue.choice_of_planners(options.planner)
