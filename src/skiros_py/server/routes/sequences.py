"""Routes: sequences of steps that a person edits and runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

from fastapi import APIRouter, Body, Path, Response

from skiros_py.api.sequences import (
    InsertStep,
    MoveStep,
    NewSequence,
    RunSequence,
    SequenceInfo,
    Sequences,
)
from skiros_py.api.tasks import TaskInfo, WantedStep
from skiros_py.planning.plan import Step
from skiros_py.server import sequences
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.etags import NEEDS_VERSION, VersionDep, etag, require_version, tagged
from skiros_py.server.problems import Problem, found
from skiros_py.server.routes.tasks import place_of
from skiros_py.server.services import Services, ServicesDep
from skiros_py.station.documents import Document
from skiros_py.station.tasks.views import task_info

__all__ = ["router"]

router = APIRouter(tags=["sequences"])

Id = Annotated[str, Path(max_length=200)]
Number = Annotated[int, Path(ge=0, lt=1000, description="Index of the step, from 0.")]
_ONCE = RunSequence(iterate=1, anyway=False)
_EDITS = NEEDS_VERSION | tagged()


@router.get("/sequences", summary="List the sequences", dependencies=[needs(Role.VIEWER)])
def list_sequences(services: ServicesDep) -> Sequences:
    """The sequences that were put together, by id; they outlive the server."""
    return Sequences(items=tuple(map(sequences.summary, services.documents.all(sequences.KIND))))


@router.post(
    "/sequences", status_code=201, summary="Make a sequence", dependencies=[needs(Role.OPERATOR)], responses=tagged(201)
)
def create_sequence(request: NewSequence, services: ServicesDep, response: Response) -> SequenceInfo:
    """Makes a sequence from scratch, of given steps, or of the plan for a goal, of a job, a task or a preview."""
    document = sequences.create(services, request)
    response.headers["Location"] = f"/api/v1/sequences/{document.name}"
    return _told(services, document, response)


@router.get("/sequences/{id}", summary="Look at a sequence", dependencies=[needs(Role.VIEWER)], responses=tagged())
def get_sequence(id: Id, services: ServicesDep, response: Response) -> SequenceInfo:  # noqa: A002 - as the address says it
    """Its steps, each checked as things are now and as the steps before it would leave them."""
    return _told(services, _find(services, id), response)


@router.delete(
    "/sequences/{id}",
    status_code=204,
    summary="Delete a sequence",
    dependencies=[needs(Role.OPERATOR)],
    responses=NEEDS_VERSION,
)
def delete_sequence(id: Id, services: ServicesDep, seen: VersionDep) -> None:  # noqa: A002
    """Throws a sequence away; what runs of it goes on. `If-Match` says which version."""
    document = _find(services, id)
    require_version(seen, document.version)
    services.documents.remove(sequences.KIND, id, expects=document.version)


@router.post("/sequences/{id}/steps", summary="Insert a step", dependencies=[needs(Role.OPERATOR)], responses=_EDITS)
def insert_step(
    id: Id,  # noqa: A002
    request: InsertStep,
    services: ServicesDep,
    seen: VersionDep,
    response: Response,
) -> SequenceInfo:
    """Adds a step before another one, or at the end; all steps are answered, checked."""
    step = _read(services, request)

    def edit(steps: list[Step]) -> None:
        at = len(steps) if request.at is None else request.at
        if at > len(steps):
            raise Problem(422, "InvalidRequest", f"at: from 0 to {len(steps)}, the end, not {at}")
        steps.insert(at, step)

    return _edited(services, id, seen, response, edit)


@router.put(
    "/sequences/{id}/steps/{number}", summary="Change a step", dependencies=[needs(Role.OPERATOR)], responses=_EDITS
)
def change_step(
    id: Id,  # noqa: A002
    number: Number,
    request: WantedStep,
    services: ServicesDep,
    seen: VersionDep,
    response: Response,
) -> SequenceInfo:
    """Puts another step in the place of one; all steps are answered, checked."""
    step = _read(services, request)

    def edit(steps: list[Step]) -> None:
        steps[_at(steps, number)] = step

    return _edited(services, id, seen, response, edit)


@router.delete(
    "/sequences/{id}/steps/{number}", summary="Take a step out", dependencies=[needs(Role.OPERATOR)], responses=_EDITS
)
def remove_step(id: Id, number: Number, services: ServicesDep, seen: VersionDep, response: Response) -> SequenceInfo:  # noqa: A002
    """Takes a step out; all others are answered, checked."""

    def edit(steps: list[Step]) -> None:
        del steps[_at(steps, number)]

    return _edited(services, id, seen, response, edit)


@router.post(
    "/sequences/{id}/steps/{number}/move", summary="Move a step", dependencies=[needs(Role.OPERATOR)], responses=_EDITS
)
def move_step(
    id: Id,  # noqa: A002
    number: Number,
    request: MoveStep,
    services: ServicesDep,
    seen: VersionDep,
    response: Response,
) -> SequenceInfo:
    """Moves a step to another place; all steps are answered, checked."""

    def edit(steps: list[Step]) -> None:
        step = steps.pop(_at(steps, number))
        if request.to > len(steps):
            raise Problem(422, "InvalidRequest", f"to: from 0 to {len(steps)}, the end, not {request.to}")
        steps.insert(request.to, step)

    return _edited(services, id, seen, response, edit)


@router.post("/sequences/{id}/run", status_code=202, summary="Run a sequence", dependencies=[needs(Role.OPERATOR)])
def run_sequence(
    id: Id,  # noqa: A002
    services: ServicesDep,
    caller: CallerDep,
    response: Response,
    request: Annotated[RunSequence, Body()] = _ONCE,
) -> TaskInfo:
    """Runs the steps as they are, so often as wanted; refused (409) where one cannot work, unless `anyway`."""
    steps = sequences.steps_in(_find(services, id))
    task = sequences.begin_steps(services, steps, request.iterate, caller.name, anyway=request.anyway)
    response.headers["Location"] = place_of(task)
    return task_info(task)


# ---------------------------------------------------------------------- parts


def _find(services: Services, id_: str) -> Document:
    with found():
        return services.documents.find(sequences.KIND, id_)


def _told(services: Services, document: Document, response: Response) -> SequenceInfo:
    response.headers["ETag"] = etag(document.version)
    return sequences.sequence_info(services.session, document)


def _read(services: Services, step: WantedStep) -> Step:
    return sequences.steps_of(services.session, [step])[0]


def _at(steps: list[Step], number: int) -> int:
    with found():
        return sequences.index(steps, number)


def _edited(
    services: Services, id_: str, seen: str | None, response: Response, edit: Callable[[list[Step]], None]
) -> SequenceInfo:
    document = _find(services, id_)
    require_version(seen, document.version)
    steps = sequences.steps_in(document)
    edit(steps)
    data = sequences.data_of(document.data["title"], steps)
    after = services.documents.put(sequences.KIND, id_, data, expects=document.version)
    return _told(services, after, response)
