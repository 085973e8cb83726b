"""Routes: goals, and previews of their plans."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path, Query

from skiros_py.api import goals as api
from skiros_py.api.previews import AppliedRepair, Preview, PreviewPage
from skiros_py.server.access.roles import Operator, OperatorOrMes, ViewerOrMes
from skiros_py.server.problems import NEEDS_VERSION, SeenDep, tagged, topic_router
from skiros_py.station.jobs.goals import goals_version

router = topic_router("goals")


@router.post("/goals/check")
def check_goal(act: ViewerOrMes, order: api.GoalOrder) -> api.CheckedGoal:
    """Check a goal.

    Returns how a goal is understood, whether each condition holds now, and why not; nothing is ordered.
    """
    return act.station.goals.check(order)


@router.get("/goals", responses=tagged())
def get_goals(act: ViewerOrMes) -> api.SceneGoals:
    """Get the goals of the scene.

    Returns the goals stored with the scene; they are pursued only if they are ordered as a job.
    """
    goals = act.station.goals.get()
    return act.tagged(goals, goals_version(goals.goals))


@router.put("/goals", responses=NEEDS_VERSION | tagged())
def put_goals(act: Operator, body: api.GoalTexts, seen: SeenDep) -> api.SceneGoals:
    """Replace the goals of the scene.

    Replaces the goals stored with the scene; `If-Match` names the version that was seen.
    """
    goals = act.station.goals.put(body, seen, act.author)
    return act.tagged(goals, goals_version(goals.goals))


@router.get("/goals/conditions")
def list_goal_conditions(
    act: ViewerOrMes,
    every: Annotated[bool, Query(alias="all")] = False,
) -> api.ConditionWords:
    """List the conditions of goals.

    Lists the conditions that the present robots can achieve, with the classes of their arguments.

    Parameters:
        all: Include conditions that no present robot can achieve.
    """
    return act.station.goals.words(every=every)


previews_router = topic_router("previews")

PreviewId = Annotated[
    str, Path(alias="id", min_length=1, max_length=20, examples=["1"], description="Id of the preview.")
]


@previews_router.post("/previews", status_code=202)
def ask_preview(act: OperatorOrMes, order: api.GoalOrder) -> Preview:
    """Plan without executing.

    Plans for a goal from the current beliefs; nothing is executed. At most two previews are planned at a time.
    """
    preview = act.station.previews.ask(order)
    act.locate("previews", preview.id)
    act.response.headers["Retry-After"] = "1"
    return preview


@previews_router.get("/previews")
def list_previews(act: OperatorOrMes) -> PreviewPage:
    """List previews.

    Lists the last hundred previews, newest first; they are deleted at a restart or when another scene is loaded.
    """
    return act.station.previews.all()


@previews_router.get("/previews/{id}")
def get_preview(
    act: OperatorOrMes, preview: PreviewId, wait: Annotated[float, Query(ge=0.0, le=30.0)] = 0.0
) -> Preview:
    """Get a preview.

    Returns the plan with its order and planned start times, or why there is no plan, and what would help.

    Parameters:
        wait: Maximum time to wait for the result [s].
    """
    return act.station.previews.get(preview, wait)


@previews_router.post("/previews/{id}/repairs/{number}/apply")
def apply_repair(
    act: Operator,
    preview: PreviewId,
    number: Annotated[int, Path(ge=0, le=1000, examples=[0])],
) -> AppliedRepair:
    """Apply a repair.

    Applies the changes of a repair to the world, as one transaction by the caller; the goal is not ordered.

    Parameters:
        number: Number of the repair.
    """
    return act.station.previews.apply_repair(preview, number, act.author)
