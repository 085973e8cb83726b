"""Routes: tasks."""

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


@router.get("/tasks", dependencies=[needs(Role.VIEWER)])
def list_tasks(
    station: StationDep,
    active: bool | None = None,
    limit: Annotated[int, Query(ge=1, le=1000)] = 100,
) -> Tasks:
    """List the tasks.

    Lists the tasks of jobs and others, newest first; the last 100 ended tasks are kept.

    Parameters:
        active: Only active tasks, or only ended ones.
    """
    return station.tasks.all(active=active, limit=limit)


@router.post("/tasks", status_code=202, dependencies=[needs(Role.OPERATOR)])
def begin_task(request: NewTask, station: StationDep, caller: CallerDep, response: Response) -> TaskInfo:
    """Start a task.

    Starts to pursue a goal, or to run steps or a sequence without planning, immediately; unlike a job, a task does not
    survive a restart.

    For a person at the robot; a factory system orders jobs. Steps are refused (409) if one cannot work, unless
    `anyway`.
    """
    task = station.tasks.begin(request, caller.author)
    response.headers["Location"] = place_of(task)
    return task


@router.get("/tasks/{name}", dependencies=[needs(Role.VIEWER)])
def get_task(name: Name, station: StationDep) -> TaskInfo:
    """Get a task.

    Returns its state, its plan with order and start times, the steps started, its questions, and its outcome.
    """
    return station.tasks.get(name)


@router.get("/tasks/{name}/trace", dependencies=[needs(Role.VIEWER)])
def get_task_trace(
    name: Name,
    station: StationDep,
    limit: Annotated[int, Query(ge=1, le=1000)] = 1000,
) -> TaskTrace:
    """Get the trace of a task.

    Lists what happened, as text and as data, oldest first; at most the last 1000 entries are kept.

    Parameters:
        limit: Maximum number of entries, counted from the last one.
    """
    return station.tasks.trace(name, limit)


@router.post("/tasks/{name}/{command}", dependencies=[needs(Role.OPERATOR)])
def command_task(name: Name, command: Command, station: StationDep, caller: CallerDep) -> TaskInfo:
    """Command a task.

    Pauses or resumes a task, executes one step, or stops it, from the next control cycle on.

    A task of a job is commanded through the job.
    """
    return station.tasks.command(name, command, caller.author)
