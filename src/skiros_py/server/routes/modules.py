"""Routes: skill managers, modules and their runs, plug-ins, and documents that robots run."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Path, Query, Response

from skiros_py.api.modules import (
    DocumentContent,
    DocumentInfo,
    DocumentKinds,
    Documents,
    ManagerInfo,
    ModuleDetails,
    ModuleRunInfo,
    ModuleRuns,
    ModuleSummary,
    PanelInfo,
    PanelRequest,
    PluginFaultInfo,
    Plugins,
    RunModule,
    SetBreakpoints,
    SkillInfo,
)
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import NEEDS_VERSION, SeenDep, etag, tagged
from skiros_py.server.services import StationDep

router = APIRouter(tags=["modules"])

Id = Annotated[str, Path(max_length=200)]
Command = Literal["pause", "resume", "step", "stop"]


def location_of(run: ModuleRunInfo) -> str:
    """Returns the address of a run."""
    return f"/api/v1/module-runs/{run.id}"


@router.get("/managers", dependencies=[needs(Role.VIEWER)])
def list_managers(station: StationDep) -> list[ManagerInfo]:
    """List the skill managers.

    Every subsystem of a robot that can do something, what it runs now, and why it is lost, if so.
    """
    return station.modules.managers()


@router.put("/managers/{agent}", dependencies=[needs(Role.ENGINEER)])
def open_manager(agent: Id, station: StationDep) -> ManagerInfo:
    """Open a skill manager.

    Opens the skill manager of a subsystem, such as one that was closed or lost: its skills are on offer again.
    """
    return station.modules.open_manager(agent)


@router.delete("/managers/{agent}", status_code=204, dependencies=[needs(Role.ENGINEER)])
def close_manager(
    agent: Id,
    station: StationDep,
    force: Annotated[bool, Query(description="Stop first what it runs.")] = False,
) -> None:
    """Close a skill manager.

    Closes the skill manager of a subsystem: its skills leave the world model, and nothing is planned with them.

    Refused (409) while it runs something, unless `force`.
    """
    station.modules.close_manager(agent, force=force)


@router.get("/modules", dependencies=[needs(Role.VIEWER)])
def list_modules(station: StationDep) -> list[ModuleSummary]:
    """List all modules.

    Every skill and primitive once, with the subsystems that can run it.
    """
    return station.modules.all()


@router.get("/modules/{agent}/{module}", dependencies=[needs(Role.VIEWER)])
def get_module(agent: Id, module: Id, station: StationDep) -> ModuleDetails:
    """Describe a module.

    Parameters with JSON schema, conditions, and the ways of doing it; parameters for planning are marked.
    """
    return station.modules.get(agent, module)


@router.post("/modules/{agent}/{module}/panel", dependencies=[needs(Role.ENGINEER)])
def show_panel(agent: Id, module: Id, request: PanelRequest, station: StationDep) -> PanelInfo:
    """Look before it runs.

    What a module would be run with now, which of its conditions hold, and why the others do not; nothing runs.
    """
    return station.modules.panel(agent, module, request.arguments)


@router.post("/modules/{agent}/{module}/runs", status_code=202, dependencies=[needs(Role.ENGINEER)])
def run_module(
    agent: Id, module: Id, request: RunModule, station: StationDep, caller: CallerDep, response: Response
) -> ModuleRunInfo:
    """Run a module by itself.

    Starts a skill or primitive, so many times one after the other, and returns at once.

    It is answered where the run can be followed (`Location`). It waits for devices that something else uses.
    """
    run = station.modules.run(
        agent,
        module,
        request.arguments,
        repeat=request.repeat,
        author=caller.author,
        breakpoints=request.breakpoints,
    )
    response.headers["Location"] = location_of(run)
    return run


@router.post("/modules/{agent}/{module}/reset", status_code=204, dependencies=[needs(Role.ENGINEER)])
def reset_module(agent: Id, module: Id, station: StationDep) -> None:
    """Reset a module.

    Makes a module fit to run again after a fault: what it keeps between runs is made again.
    """
    station.modules.reset(agent, module)


@router.get("/module-runs", dependencies=[needs(Role.VIEWER)])
def list_module_runs(
    station: StationDep,
    active: Annotated[bool | None, Query(description="Only what is under way, or only what is over.")] = None,
    limit: Annotated[int, Query(ge=1, le=1000, description="So many at most.")] = 100,
) -> ModuleRuns:
    """List runs of modules.

    What was started from outside, the youngest first; of what is over the last 200 are kept.
    """
    return station.modules.runs(active=active, limit=limit)


@router.get("/module-runs/{id}", dependencies=[needs(Role.VIEWER)])
def get_module_run(id: Id, station: StationDep) -> ModuleRunInfo:  # noqa: A002 - as the address says it
    """Follow a run.

    How far it is, what was inferred, what it reported, what it wrote into the world, and what came of it.
    """
    return station.modules.get_run(id)


@router.put("/module-runs/{id}/breakpoints", dependencies=[needs(Role.ENGINEER)])
def set_breakpoints(id: Id, request: SetBreakpoints, station: StationDep) -> ModuleRunInfo:  # noqa: A002
    """Set breakpoints.

    Pauses a run before these nodes and no others; the command `resume` lets it go on.
    """
    return station.modules.set_breakpoints(id, request.paths)


@router.post("/module-runs/{id}/{command}", dependencies=[needs(Role.ENGINEER)])
def command_module_run(id: Id, command: Command, station: StationDep) -> ModuleRunInfo:  # noqa: A002
    """Command a run.

    Pauses it where it stands, resumes it, lets it do one cycle while it is paused, or stops it at once.
    """
    return station.modules.command_run(id, command)


@router.get("/skills", dependencies=[needs(Role.VIEWER)])
def list_skills(station: StationDep) -> list[SkillInfo]:
    """List the skills.

    The skills that somebody offers now, as people and planners see them: parameters, conditions, effects.
    """
    return station.modules.skills()


@router.get("/skills/{name}", dependencies=[needs(Role.VIEWER)])
def get_skill(name: Id, station: StationDep) -> SkillInfo:
    """Describe a skill.

    One skill, apart from how it is done.
    """
    return station.modules.skill(name)


plugins_router = APIRouter(tags=["plugins"])


@plugins_router.get("/plugins", dependencies=[needs(Role.ENGINEER)])
def list_plugins(station: StationDep) -> Plugins:
    """List the plug-ins.

    Every entry point that is installed, from which distribution, and whether it works; as the server started.
    """
    return station.plugins.all()


@plugins_router.get("/plugins/faults", dependencies=[needs(Role.ENGINEER)])
def list_plugin_faults(station: StationDep) -> list[PluginFaultInfo]:
    """List broken plug-ins.

    What does not load or fit into the present scene, with the traceback for its author; all else works.
    """
    return station.plugins.faults()


documents_router = APIRouter(tags=["documents"])

KindName = Annotated[str, Path(min_length=1, max_length=100, description="Kind of the document.", examples=["tree"])]
DocumentsId = Annotated[
    str, Path(min_length=1, max_length=200, description="Id of the document.", examples=["tidy up"])
]


@documents_router.get("/documents", dependencies=[needs(Role.VIEWER)])
def list_document_kinds(station: StationDep) -> DocumentKinds:
    """List the kinds of documents.

    Lists the kinds of documents that plug-ins bring, each with the nodes that an editor offers.
    """
    return station.behaviours.kinds()


@documents_router.get("/documents/{kind}", dependencies=[needs(Role.VIEWER)])
def list_documents(kind: KindName, station: StationDep) -> Documents:
    """List documents.

    Lists the documents of a kind, by id.
    """
    return station.behaviours.all(kind)


@documents_router.get("/documents/{kind}/{id}", dependencies=[needs(Role.VIEWER)], responses=tagged())
def get_document(kind: KindName, id: DocumentsId, station: StationDep, response: Response) -> DocumentInfo:  # noqa: A002
    """Look at a document.

    Shows a document as it is now; it runs as the module `{kind}:{id}`.
    """
    return _tagged(station.behaviours.get(kind, id), response)


@documents_router.get("/documents/{kind}/{id}/revisions", dependencies=[needs(Role.VIEWER)])
def list_document_revisions(kind: KindName, id: DocumentsId, station: StationDep) -> Documents:  # noqa: A002
    """List revisions.

    Lists all revisions of a document, the oldest first; also of one that was removed.
    """
    return station.behaviours.revisions(kind, id)


@documents_router.put(
    "/documents/{kind}/{id}",
    dependencies=[needs(Role.OPERATOR)],
    responses=NEEDS_VERSION
    | tagged()
    | {201: {"model": DocumentInfo, "description": "It is new.", **tagged(201)[201]}},
)
def put_document(
    kind: KindName,
    id: DocumentsId,  # noqa: A002
    content: DocumentContent,
    station: StationDep,
    seen: SeenDep,
    response: Response,
) -> DocumentInfo:
    """Write a document.

    Writes a document; for one that is there already, `If-Match` names the revision that was seen.

    It is checked first: a fault is answered with its place. Its next run is of this revision; what runs goes on.
    """
    document, new = station.behaviours.put(kind, id, content.data, seen)
    response.status_code = 201 if new else 200
    return _tagged(document, response)


@documents_router.delete(
    "/documents/{kind}/{id}", status_code=204, dependencies=[needs(Role.OPERATOR)], responses=NEEDS_VERSION
)
def remove_document(kind: KindName, id: DocumentsId, station: StationDep, seen: SeenDep) -> None:  # noqa: A002
    """Remove a document.

    Removes a document; `If-Match` names the revision that was seen. What runs of it goes on.
    """
    station.behaviours.remove(kind, id, seen)


def _tagged(document: DocumentInfo, response: Response) -> DocumentInfo:
    response.headers["ETag"] = etag(document.revision)
    return document
