"""Routes: tasks."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path, Query

from skiros_py.api.modules import RunCommand
from skiros_py.api.tasks import NewTask, TaskInfo, Tasks, TaskTrace
from skiros_py.server.access.roles import Operator, Viewer
from skiros_py.server.problems import topic_router

router = topic_router("tasks")

Name = Annotated[str, Path(max_length=200, examples=["task 1"])]


@router.get("/tasks")
def list_tasks(
    act: Viewer,
    active: bool | None = None,
    limit: Annotated[int, Query(ge=1, le=1000)] = 100,
) -> Tasks:
    """List the tasks.

    Lists the tasks of jobs and others, newest first; the last 100 ended tasks are kept.

    Parameters:
        active: Only active tasks, or only ended ones.
    """
    return act.station.tasks.all(active=active, limit=limit)


@router.post("/tasks", status_code=202)
def begin_task(act: Operator, request: NewTask) -> TaskInfo:
    """Start a task.

    Starts to pursue a goal, or to run steps or a sequence without planning, immediately; unlike a job, a task does not
    survive a restart.

    For a person at the robot; a factory system orders jobs. Steps are refused (409) if one cannot work, unless
    `anyway`.
    """
    task = act.station.tasks.begin(request, act.author)
    act.locate("tasks", task.name)
    return task


@router.get("/tasks/{name}")
def get_task(act: Viewer, name: Name) -> TaskInfo:
    """Get a task.

    Returns its state, its plan with order and start times, the steps started, its questions, and its outcome.
    """
    return act.station.tasks.get(name)


@router.get("/tasks/{name}/trace")
def get_task_trace(
    act: Viewer,
    name: Name,
    limit: Annotated[int, Query(ge=1, le=1000)] = 1000,
) -> TaskTrace:
    """Get the trace of a task.

    Lists what happened, as text and as data, oldest first; at most the last 1000 entries are kept.

    Parameters:
        limit: Maximum number of entries, counted from the last one.
    """
    return act.station.tasks.trace(name, limit)


@router.post("/tasks/{name}/{command}")
def command_task(act: Operator, name: Name, command: RunCommand) -> TaskInfo:
    """Command a task.

    Pauses or resumes a task, executes one step, or stops it, from the next control cycle on.

    A task of a job is commanded through the job.
    """
    return act.station.tasks.command(name, command, act.author)
