"""Tasks: goals being pursued, for jobs or independently."""

from __future__ import annotations

from typing import Literal

from skiros_py.api.tasks import NewTask, TaskInfo, Tasks, TaskTrace
from skiros_py.client.request import Call, path_of


def list_tasks(*, active: bool | None = None, limit: int | None = None) -> Call[Tasks]:
    """Lists the tasks, newest first."""
    query = {"active": None if active is None else str(active).lower(), "limit": limit}
    return Call("GET", "/tasks", Tasks, query=query)


def begin_task(task: NewTask) -> Call[TaskInfo]:
    """Starts pursuing a goal or running steps at once, bypassing the job queue."""
    return Call("POST", "/tasks", TaskInfo, json=task.model_dump(mode="json"), repeatable=False)


def get_task(name: str) -> Call[TaskInfo]:
    """Returns the progress or result of a task."""
    return Call("GET", path_of("tasks", name), TaskInfo)


def get_task_trace(name: str, *, limit: int | None = None) -> Call[TaskTrace]:
    """Returns the trace of a task."""
    return Call("GET", path_of("tasks", name, "trace"), TaskTrace, query={"limit": limit})


def command_task(name: str, command: Literal["pause", "resume", "step", "stop"]) -> Call[TaskInfo]:
    """Pauses, resumes, single-steps or stops a task."""
    return Call("POST", path_of("tasks", name, command), TaskInfo, repeatable=command != "step")
