"""Routes: previews, what would be done for a goal."""

from __future__ import annotations

from typing import Annotated
from urllib.parse import quote

from fastapi import APIRouter, Path, Query, Response

from skiros_py.api.goals import GoalOrder
from skiros_py.api.previews import AppliedRepair, Preview, PreviewPage, PreviewState, Repair
from skiros_py.api.wire import moment
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.job_faults import job_faults
from skiros_py.server.problems import Problem, found
from skiros_py.server.routes.job_access import TemplatesDep
from skiros_py.server.services import ServicesDep
from skiros_py.station.jobs.accounts import planned_steps
from skiros_py.station.jobs.orders import texts_of
from skiros_py.station.tasks.previews import Preview as Known
from skiros_py.station.tasks.previews import is_applicable
from skiros_py.world.change import Writer

__all__ = ["router"]

router = APIRouter(tags=["previews"])

_NEEDS = [needs(Role.OPERATOR, mes=True)]
PreviewId = Annotated[str, Path(min_length=1, max_length=20, description="Id of the preview.", examples=["1"])]


@router.post("/previews", summary="Plan without doing", status_code=202, dependencies=_NEEDS)
def ask_preview(order: GoalOrder, services: ServicesDep, templates: TemplatesDep, response: Response) -> Preview:
    """Begins to plan for a goal from what is believed now; nothing is done. At most two are planned at a time."""
    with job_faults():
        goal = texts_of(order, templates)
        services.session.parse(goal)
    capabilities = services.control.call(lambda session: session.tasks.capabilities)
    preview = services.previews.ask(services.session, goal, capabilities)
    response.headers["Location"] = f"/api/v1/previews/{quote(preview.id, safe='')}"
    response.headers["Retry-After"] = "1"
    return _shown(preview)


@router.get("/previews", summary="List previews", dependencies=_NEEDS)
def list_previews(services: ServicesDep) -> PreviewPage:
    """Lists the previews that are kept, the latest first: a hundred, and none over a restart or another scene."""
    return PreviewPage(items=tuple(map(_shown, services.previews.all())))


@router.get("/previews/{id}", summary="Look at a preview", dependencies=_NEEDS)
def get_preview(
    id: PreviewId,  # noqa: A002 - the name in the address
    services: ServicesDep,
    wait: Annotated[float, Query(ge=0.0, le=30.0, description="How long to wait for the answer [s].")] = 0.0,
) -> Preview:
    """Shows the plan with order and planned starts; or why there is none, and what would help."""
    with found():
        preview = services.previews.find(id)
    services.desk.wait_for(preview.ended, wait)
    return _shown(preview)


@router.post("/previews/{id}/repairs/{number}/apply", summary="Make a repair", dependencies=[needs(Role.OPERATOR)])
def apply_repair(
    id: PreviewId,  # noqa: A002 - the name in the address
    number: Annotated[int, Path(ge=0, le=1000, description="Number of the repair.", examples=[0])],
    services: ServicesDep,
    caller: CallerDep,
) -> AppliedRepair:
    """Makes what a repair changes in the world, as one transaction by the caller; the goal is left to them."""
    with found():
        repair = services.previews.find(id).repair(number)
    if not is_applicable(repair):
        raise Problem(
            409,
            "RepairNotApplicable",
            f"'{repair.text}' is no change of the world: see to it, or order otherwise",
        )
    world = services.session.world
    repair.apply(world, caller.name, Writer.PERSON, caller.holder)
    return AppliedRepair(text=repair.done, world=world.version)


def _shown(preview: Known) -> Preview:
    planned, plan, none = preview.planned, preview.plan, preview.no_plan
    return Preview(
        id=preview.id,
        state=_state(preview),
        goal=preview.goal,
        conditions=tuple(map(str, preview.conditions)),
        world=preview.world,
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
