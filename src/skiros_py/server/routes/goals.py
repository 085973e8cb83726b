"""Routes: goals, and previews of their plans."""

from __future__ import annotations

from typing import Annotated
from urllib.parse import quote

from fastapi import APIRouter, Path, Query, Response

from skiros_py.api.goals import (
    CheckedGoal,
    ConditionWords,
    GoalOrder,
    GoalTexts,
    SceneGoals,
)
from skiros_py.api.previews import AppliedRepair, Preview, PreviewPage
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import NEEDS_VERSION, SeenDep, etag, tagged
from skiros_py.server.services import StationDep
from skiros_py.station.jobs.goals import goals_version

router = APIRouter(tags=["goals"])


@router.post("/goals/check", dependencies=[needs(Role.VIEWER, mes=True)])
def check_goal(order: GoalOrder, station: StationDep) -> CheckedGoal:
    """Check a goal.

    Returns how a goal is understood, whether each condition holds now, and why not; nothing is ordered.
    """
    return station.goals.check(order)


@router.get("/goals", dependencies=[needs(Role.VIEWER, mes=True)], responses=tagged())
def get_goals(station: StationDep, response: Response) -> SceneGoals:
    """Get the goals of the scene.

    Returns the goals stored with the scene; they are pursued only if they are ordered as a job.
    """
    return _tagged(station.goals.get(), response)


@router.put("/goals", dependencies=[needs(Role.OPERATOR)], responses=NEEDS_VERSION | tagged())
def put_goals(body: GoalTexts, station: StationDep, caller: CallerDep, seen: SeenDep, response: Response) -> SceneGoals:
    """Replace the goals of the scene.

    Replaces the goals stored with the scene; `If-Match` names the version that was seen.
    """
    goals = station.goals.put(body, seen, caller.author)
    return _tagged(goals, response)


@router.get("/goals/conditions", dependencies=[needs(Role.VIEWER, mes=True)])
def list_goal_conditions(
    station: StationDep,
    every: Annotated[bool, Query(alias="all")] = False,
) -> ConditionWords:
    """List the conditions of goals.

    Lists the conditions that the present robots can achieve, with the classes of their arguments.

    Parameters:
        all: Include conditions that no present robot can achieve.
    """
    return station.goals.words(every=every)


def _tagged(goals: SceneGoals, response: Response) -> SceneGoals:
    response.headers["ETag"] = etag(goals_version(goals.goals))
    return goals


previews_router = APIRouter(tags=["previews"])

_NEEDS = [needs(Role.OPERATOR, mes=True)]
PreviewId = Annotated[
    str, Path(alias="id", min_length=1, max_length=20, examples=["1"], description="Id of the preview.")
]


@previews_router.post("/previews", status_code=202, dependencies=_NEEDS)
def ask_preview(order: GoalOrder, station: StationDep, response: Response) -> Preview:
    """Plan without executing.

    Plans for a goal from the current beliefs; nothing is executed. At most two previews are planned at a time.
    """
    preview = station.previews.ask(order)
    response.headers["Location"] = f"/api/v1/previews/{quote(preview.id, safe='')}"
    response.headers["Retry-After"] = "1"
    return preview


@previews_router.get("/previews", dependencies=_NEEDS)
def list_previews(station: StationDep) -> PreviewPage:
    """List previews.

    Lists the last hundred previews, newest first; they are deleted at a restart or when another scene is loaded.
    """
    return station.previews.all()


@previews_router.get("/previews/{id}", dependencies=_NEEDS)
def get_preview(
    preview: PreviewId, station: StationDep, wait: Annotated[float, Query(ge=0.0, le=30.0)] = 0.0
) -> Preview:
    """Get a preview.

    Returns the plan with its order and planned start times, or why there is no plan, and what would help.

    Parameters:
        wait: Maximum time to wait for the result [s].
    """
    return station.previews.get(preview, wait)


@previews_router.post("/previews/{id}/repairs/{number}/apply", dependencies=[needs(Role.OPERATOR)])
def apply_repair(
    preview: PreviewId,
    number: Annotated[int, Path(ge=0, le=1000, examples=[0])],
    station: StationDep,
    caller: CallerDep,
) -> AppliedRepair:
    """Apply a repair.

    Applies the changes of a repair to the world, as one transaction by the caller; the goal is not ordered.

    Parameters:
        number: Number of the repair.
    """
    return station.previews.apply_repair(preview, number, caller.author)
