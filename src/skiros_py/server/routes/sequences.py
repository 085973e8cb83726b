"""Routes: sequences of steps that a person edits and runs."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Body, Path, Response

from skiros_py.api.sequences import InsertStep, MoveStep, NewSequence, RunSequence, SequenceInfo, Sequences
from skiros_py.api.tasks import TaskInfo, WantedStep
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.etags import NEEDS_VERSION, SeenDep, tagged, with_etag
from skiros_py.server.routes.tasks import place_of
from skiros_py.server.services import StationDep

router = APIRouter(tags=["sequences"])

Id = Annotated[str, Path(max_length=200)]
Number = Annotated[int, Path(ge=0, lt=1000, description="Index of the step, from 0.")]
_ONCE = RunSequence(iterate=1, anyway=False)
_EDITS = NEEDS_VERSION | tagged()


@router.get("/sequences", summary="List the sequences", dependencies=[needs(Role.VIEWER)])
def list_sequences(station: StationDep) -> Sequences:
    """The sequences that were put together, by id; they outlive the server."""
    return station.sequences.all()


@router.post(
    "/sequences", status_code=201, summary="Make a sequence", dependencies=[needs(Role.OPERATOR)], responses=tagged(201)
)
def create_sequence(request: NewSequence, station: StationDep, response: Response) -> SequenceInfo:
    """Makes a sequence from scratch, of given steps, or of the plan for a goal, of a job, a task or a preview."""
    sequence = station.sequences.create(request)
    response.headers["Location"] = f"/api/v1/sequences/{sequence.id}"
    return with_etag(sequence, response)


@router.get("/sequences/{id}", summary="Look at a sequence", dependencies=[needs(Role.VIEWER)], responses=tagged())
def get_sequence(id: Id, station: StationDep, response: Response) -> SequenceInfo:  # noqa: A002 - as the address says it
    """Its steps, each checked as things are now and as the steps before it would leave them."""
    return with_etag(station.sequences.get(id), response)


@router.delete(
    "/sequences/{id}",
    status_code=204,
    summary="Delete a sequence",
    dependencies=[needs(Role.OPERATOR)],
    responses=NEEDS_VERSION,
)
def delete_sequence(id: Id, station: StationDep, seen: SeenDep) -> None:  # noqa: A002
    """Throws a sequence away; what runs of it goes on. `If-Match` says which version."""
    station.sequences.delete(id, seen)


@router.post("/sequences/{id}/steps", summary="Insert a step", dependencies=[needs(Role.OPERATOR)], responses=_EDITS)
def insert_step(
    id: Id,  # noqa: A002
    request: InsertStep,
    station: StationDep,
    seen: SeenDep,
    response: Response,
) -> SequenceInfo:
    """Adds a step before another one, or at the end; all steps are answered, checked."""
    return with_etag(station.sequences.insert_step(id, request, seen), response)


@router.put(
    "/sequences/{id}/steps/{number}", summary="Change a step", dependencies=[needs(Role.OPERATOR)], responses=_EDITS
)
def change_step(
    id: Id,  # noqa: A002
    number: Number,
    request: WantedStep,
    station: StationDep,
    seen: SeenDep,
    response: Response,
) -> SequenceInfo:
    """Puts another step in the place of one; all steps are answered, checked."""
    return with_etag(station.sequences.change_step(id, number, request, seen), response)


@router.delete(
    "/sequences/{id}/steps/{number}", summary="Take a step out", dependencies=[needs(Role.OPERATOR)], responses=_EDITS
)
def remove_step(id: Id, number: Number, station: StationDep, seen: SeenDep, response: Response) -> SequenceInfo:  # noqa: A002
    """Takes a step out; all others are answered, checked."""
    return with_etag(station.sequences.remove_step(id, number, seen), response)


@router.post(
    "/sequences/{id}/steps/{number}/move", summary="Move a step", dependencies=[needs(Role.OPERATOR)], responses=_EDITS
)
def move_step(
    id: Id,  # noqa: A002
    number: Number,
    request: MoveStep,
    station: StationDep,
    seen: SeenDep,
    response: Response,
) -> SequenceInfo:
    """Moves a step to another place; all steps are answered, checked."""
    return with_etag(station.sequences.move_step(id, number, request, seen), response)


@router.post("/sequences/{id}/run", status_code=202, summary="Run a sequence", dependencies=[needs(Role.OPERATOR)])
def run_sequence(
    id: Id,  # noqa: A002
    station: StationDep,
    caller: CallerDep,
    response: Response,
    request: Annotated[RunSequence, Body()] = _ONCE,
) -> TaskInfo:
    """Runs the steps as they are, so often as wanted; refused (409) where one cannot work, unless `anyway`."""
    task = station.sequences.run(id, request, caller.author)
    response.headers["Location"] = place_of(task)
    return task
