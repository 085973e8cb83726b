"""Tasks: what the robots pursue, for jobs and beside them."""

from __future__ import annotations

from typing import Literal

from skiros_py.api.tasks import NewTask, TaskInfo, Tasks, TaskTrace
from skiros_py.client.call import Call, path_of


def list_tasks(*, active: bool | None = None, limit: int | None = None) -> Call[Tasks]:
    """Lists the tasks, the youngest first."""
    query = {"active": None if active is None else str(active).lower(), "limit": limit}
    return Call("GET", "/tasks", Tasks, query=query)


def begin_task(task: NewTask) -> Call[TaskInfo]:
    """Begins to pursue a goal or to run steps at once, apart from the queue of jobs."""
    return Call("POST", "/tasks", TaskInfo, json=task.model_dump(mode="json"), repeatable=False)


def get_task(name: str) -> Call[TaskInfo]:
    """Returns how far a task is, or what came of it."""
    return Call("GET", path_of("tasks", name), TaskInfo)


def get_task_trace(name: str, *, limit: int | None = None) -> Call[TaskTrace]:
    """Returns what happened in a task."""
    return Call("GET", path_of("tasks", name, "trace"), TaskTrace, query={"limit": limit})


def command_task(name: str, command: Literal["pause", "resume", "step", "stop"]) -> Call[TaskInfo]:
    """Pauses a task, resumes it, lets it do one step, or stops it."""
    return Call("POST", path_of("tasks", name, command), TaskInfo, repeatable=command != "step")
