"""Use cases: previews, which plan for a goal and execute nothing."""

from __future__ import annotations

from skiros_py.api.goals import GoalOrder
from skiros_py.api.previews import AppliedRepair, Preview, PreviewPage, PreviewState, Repair
from skiros_py.api.wire import moment
from skiros_py.errors import Refused
from skiros_py.station.jobs.accounts import planned_steps
from skiros_py.station.jobs.orders import texts_of
from skiros_py.station.requests import LIBRARY, Author, Service, addressed
from skiros_py.station.tasks.previews import Preview as Known
from skiros_py.station.tasks.previews import is_applicable
from skiros_py.world.change import Writer


class PreviewService(Service):
    """Plans goals from the present beliefs, and applies the repairs offered if there is no plan."""

    def ask(self, order: GoalOrder) -> Preview:
        """Starts to plan for a goal, and returns immediately.

        Raises:
            UsageError: The goal cannot be parsed.
        """
        station = self._station
        goal = texts_of(order, station.document_store)
        station.session.parse(goal)
        capabilities = station.control.call(lambda session: session.tasks.capabilities)
        return _shown(station.preview_book.ask(station.session, goal, capabilities))

    def all(self) -> PreviewPage:
        """Lists the previews kept, latest first."""
        return PreviewPage(items=tuple(map(_shown, self._station.preview_book.all())))

    def get(self, id_: str, wait: float = 0.0) -> Preview:
        """Returns the plan with order and planned starts; or why there is none, and possible repairs.

        Args:
            id_: Id of the preview.
            wait: Maximum wait for the answer [s].

        Raises:
            NotFound: There is none with this id.
        """
        with addressed():
            preview = self._station.preview_book.find(id_)
        self._station.waiter.wait_for(preview.ended, wait)
        return _shown(preview)

    def apply_repair(self, id_: str, number: int, author: Author = LIBRARY) -> AppliedRepair:
        """Applies a repair to the world, as one transaction; the goal is not changed.

        Raises:
            NotFound: There is no such preview or repair.
            Refused: It does not change the world.
        """
        with addressed():
            repair = self._station.preview_book.find(id_).repair(number)
        if not is_applicable(repair):
            text = f"'{repair.text}' is no change of the world: see to it, or order otherwise"
            raise Refused("RepairNotApplicable", text)
        world = self._station.session.world
        repair.apply(world, author.name, Writer.PERSON, author.holder)
        return AppliedRepair(text=repair.done, world=world.version)


def _shown(preview: Known) -> Preview:
    planned, plan, none = preview.planned, preview.plan, preview.no_plan
    return Preview.view_of(
        preview,
        state=_state(preview),
        conditions=tuple(map(str, preview.conditions)),
        asked=moment(preview.asked),
        wall=None if planned is None else planned.wall,
        planner="" if planned is None else planned.planner,
        steps=() if plan is None else planned_steps(plan),
        reasons=((preview.fault,) if preview.fault else ()) if none is None else none.reasons,
        causes=() if none is None else tuple(cause.as_json() for cause in none.causes),
        repairs=tuple(
            Repair(id=number, **repair.as_json(), applicable=is_applicable(repair))
            for number, repair in enumerate(preview.repairs)
        ),
        notes=() if planned is None else planned.notes,
    )


def _state(preview: Known) -> PreviewState:
    if preview.plan is not None:
        return PreviewState.PLANNED
    if preview.no_plan is not None:
        return PreviewState.NO_PLAN
    return PreviewState.FAILED if preview.fault else PreviewState.PLANNING
