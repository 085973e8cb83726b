"""Routes: tasks under way, and those that were lately."""

from __future__ import annotations

from typing import Annotated, Literal
from urllib.parse import quote

from fastapi import APIRouter, Path, Query, Response

from skiros_py.api.tasks import NewTask, TaskInfo, Tasks, TaskTrace
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.services import StationDep

router = APIRouter(tags=["tasks"])

Name = Annotated[str, Path(max_length=200, examples=["task 1"])]
Command = Literal["pause", "resume", "step", "stop"]


def place_of(task: TaskInfo) -> str:
    """Returns the address of a task."""
    return f"/api/v1/tasks/{quote(task.name, safe='')}"


@router.get("/tasks", summary="List the tasks", dependencies=[needs(Role.VIEWER)])
def list_tasks(
    station: StationDep,
    active: Annotated[bool | None, Query(description="Only what is under way, or only what is over.")] = None,
    limit: Annotated[int, Query(ge=1, le=1000, description="So many at most.")] = 100,
) -> Tasks:
    """What the robots pursue, for jobs and beside them, the youngest first; of what is over the last 100 are kept."""
    return station.tasks.all(active=active, limit=limit)


@router.post("/tasks", status_code=202, summary="Begin a task", dependencies=[needs(Role.OPERATOR)])
def begin_task(request: NewTask, station: StationDep, caller: CallerDep, response: Response) -> TaskInfo:
    """Begins at once to pursue a goal, or to run steps as they are; it is not kept over a restart, as jobs are.

    For a person who stands at the robot; a factory system orders jobs.
    """
    task = station.tasks.begin(request, caller.author)
    response.headers["Location"] = place_of(task)
    return task


@router.get("/tasks/{name}", summary="Follow a task", dependencies=[needs(Role.VIEWER)])
def get_task(name: Name, station: StationDep) -> TaskInfo:
    """What it does, its plan with order and starts, the steps that were started, what it asks, what came of it."""
    return station.tasks.get(name)


@router.get("/tasks/{name}/trace", summary="See what happened in a task", dependencies=[needs(Role.VIEWER)])
def get_task_trace(
    name: Name,
    station: StationDep,
    limit: Annotated[int, Query(ge=1, le=1000, description="The last so many entries.")] = 1000,
) -> TaskTrace:
    """What happened, in sentences and as data, oldest first; of very much the last 1000 entries are kept."""
    return station.tasks.trace(name, limit)


@router.post("/tasks/{name}/{command}", summary="Command a task", dependencies=[needs(Role.OPERATOR)])
def command_task(name: Name, command: Command, station: StationDep, caller: CallerDep) -> TaskInfo:
    """Pauses a task, resumes it, lets it do one step, or stops it; obeyed in the coming control cycle.

    A job's task is commanded through the job.
    """
    return station.tasks.command(name, command, caller.author)
