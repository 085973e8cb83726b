"""Routes: tasks, and sequences of steps that a person edits and runs."""

from __future__ import annotations

from typing import Annotated, Literal
from urllib.parse import quote

from fastapi import APIRouter, Body, Path, Query, Response

from skiros_py.api.tasks import (
    InsertStep,
    MoveStep,
    NewSequence,
    NewTask,
    RunSequence,
    SequenceInfo,
    Sequences,
    TaskInfo,
    Tasks,
    TaskTrace,
    WantedStep,
)
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import NEEDS_VERSION, SeenDep, tagged, with_etag
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

    Starts to pursue a goal, or to run given steps, immediately; unlike a job, a task does not survive a restart.

    For a person at the robot; a factory system orders jobs.
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


sequences_router = APIRouter(tags=["sequences"])

Id = Annotated[str, Path(max_length=200)]
Number = Annotated[int, Path(ge=0, lt=1000, description="Index of the step, from 0.")]
_ONCE = RunSequence(iterate=1, anyway=False)
_EDITS = NEEDS_VERSION | tagged()


@sequences_router.get("/sequences", dependencies=[needs(Role.VIEWER)])
def list_sequences(station: StationDep) -> Sequences:
    """List the sequences.

    The sequences that were put together, by id; they outlive the server.
    """
    return station.sequences.all()


@sequences_router.post("/sequences", status_code=201, dependencies=[needs(Role.OPERATOR)], responses=tagged(201))
def create_sequence(request: NewSequence, station: StationDep, response: Response) -> SequenceInfo:
    """Make a sequence.

    Makes a sequence from scratch, of given steps, or of the plan for a goal, of a job, a task or a preview.
    """
    sequence = station.sequences.create(request)
    response.headers["Location"] = f"/api/v1/sequences/{sequence.id}"
    return with_etag(sequence, response)


@sequences_router.get("/sequences/{id}", dependencies=[needs(Role.VIEWER)], responses=tagged())
def get_sequence(id: Id, station: StationDep, response: Response) -> SequenceInfo:  # noqa: A002 - as the address says it
    """Look at a sequence.

    Its steps, each checked as things are now and as the steps before it would leave them.
    """
    return with_etag(station.sequences.get(id), response)


@sequences_router.delete(
    "/sequences/{id}", status_code=204, dependencies=[needs(Role.OPERATOR)], responses=NEEDS_VERSION
)
def delete_sequence(id: Id, station: StationDep, seen: SeenDep) -> None:  # noqa: A002
    """Delete a sequence.

    Throws a sequence away; what runs of it goes on. `If-Match` says which version.
    """
    station.sequences.delete(id, seen)


@sequences_router.post("/sequences/{id}/steps", dependencies=[needs(Role.OPERATOR)], responses=_EDITS)
def insert_step(
    id: Id,  # noqa: A002
    request: InsertStep,
    station: StationDep,
    seen: SeenDep,
    response: Response,
) -> SequenceInfo:
    """Insert a step.

    Adds a step before another one, or at the end; all steps are answered, checked.
    """
    return with_etag(station.sequences.insert_step(id, request, seen), response)


@sequences_router.put("/sequences/{id}/steps/{number}", dependencies=[needs(Role.OPERATOR)], responses=_EDITS)
def change_step(
    id: Id,  # noqa: A002
    number: Number,
    request: WantedStep,
    station: StationDep,
    seen: SeenDep,
    response: Response,
) -> SequenceInfo:
    """Change a step.

    Puts another step in the place of one; all steps are answered, checked.
    """
    return with_etag(station.sequences.change_step(id, number, request, seen), response)


@sequences_router.delete("/sequences/{id}/steps/{number}", dependencies=[needs(Role.OPERATOR)], responses=_EDITS)
def remove_step(id: Id, number: Number, station: StationDep, seen: SeenDep, response: Response) -> SequenceInfo:  # noqa: A002
    """Take a step out.

    Takes a step out; all others are answered, checked.
    """
    return with_etag(station.sequences.remove_step(id, number, seen), response)


@sequences_router.post("/sequences/{id}/steps/{number}/move", dependencies=[needs(Role.OPERATOR)], responses=_EDITS)
def move_step(
    id: Id,  # noqa: A002
    number: Number,
    request: MoveStep,
    station: StationDep,
    seen: SeenDep,
    response: Response,
) -> SequenceInfo:
    """Move a step.

    Moves a step to another place; all steps are answered, checked.
    """
    return with_etag(station.sequences.move_step(id, number, request, seen), response)


@sequences_router.post("/sequences/{id}/run", status_code=202, dependencies=[needs(Role.OPERATOR)])
def run_sequence(
    id: Id,  # noqa: A002
    station: StationDep,
    caller: CallerDep,
    response: Response,
    request: Annotated[RunSequence, Body()] = _ONCE,
) -> TaskInfo:
    """Run a sequence.

    Runs the steps as they are, so often as wanted; refused (409) where one cannot work, unless `anyway`.
    """
    task = station.sequences.run(id, request, caller.author)
    response.headers["Location"] = place_of(task)
    return task
