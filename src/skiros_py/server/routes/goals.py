"""Routes: goals. They are read and checked; what orders them is a job."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Response

from skiros_py.api.goals import CheckedGoal, ConditionWords, GoalOrder, GoalTexts, SceneGoals
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.etags import NEEDS_VERSION, SeenDep, etag, tagged
from skiros_py.server.services import StationDep
from skiros_py.station.jobs.goals import goals_version

router = APIRouter(tags=["goals"])


@router.post("/goals/check", summary="Check a goal", dependencies=[needs(Role.VIEWER, mes=True)])
def check_goal(order: GoalOrder, station: StationDep) -> CheckedGoal:
    """Says how a goal is understood, and whether each condition holds now, and why not; nothing is ordered."""
    return station.goals.check(order)


@router.get("/goals", summary="The goals of the scene", dependencies=[needs(Role.VIEWER, mes=True)], responses=tagged())
def get_goals(station: StationDep, response: Response) -> SceneGoals:
    """Shows the goals that go with the scene; they are pursued only when they are ordered as a job."""
    return _tagged(station.goals.get(), response)


@router.put(
    "/goals",
    summary="Replace the goals of the scene",
    dependencies=[needs(Role.OPERATOR)],
    responses=NEEDS_VERSION | tagged(),
)
def put_goals(body: GoalTexts, station: StationDep, caller: CallerDep, seen: SeenDep, response: Response) -> SceneGoals:
    """Replaces the goals that go with the scene; `If-Match` names the version that was seen."""
    goals = station.goals.put(body, seen, caller.author)
    return _tagged(goals, response)


@router.get("/goals/conditions", summary="The words of goals", dependencies=[needs(Role.VIEWER, mes=True)])
def list_goal_conditions(
    station: StationDep,
    every: Annotated[
        bool, Query(alias="all", description="Also those that no present robot can do anything for.")
    ] = False,
) -> ConditionWords:
    """Lists the words that the present robots can fulfil, with the classes of their arguments."""
    return station.goals.words(every=every)


def _tagged(goals: SceneGoals, response: Response) -> SceneGoals:
    response.headers["ETag"] = etag(goals_version(goals.goals))
    return goals
