"""Routes: skill managers, modules and their runs, plug-ins."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Path, Query, Response

from skiros_py.api.modules import (
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
from skiros_py.server.services import StationDep

router = APIRouter(tags=["modules"])

Id = Annotated[str, Path(max_length=200)]
RunId = Annotated[str, Path(alias="id", max_length=200)]
Command = Literal["pause", "resume", "step", "stop"]


def location_of(run: ModuleRunInfo) -> str:
    """Returns the address of a run."""
    return f"/api/v1/module-runs/{run.id}"


@router.get("/managers", dependencies=[needs(Role.VIEWER)])
def list_managers(station: StationDep) -> list[ManagerInfo]:
    """List the skill managers.

    Lists the subsystems that can execute modules, what each is executing, and why it is lost, if it is.
    """
    return station.modules.managers()


@router.put("/managers/{agent}", dependencies=[needs(Role.ENGINEER)])
def open_manager(agent: Id, station: StationDep) -> ManagerInfo:
    """Open a skill manager.

    Opens the skill manager of a subsystem, for example one that was closed or lost: its skills become available again.
    """
    return station.modules.open_manager(agent)


@router.delete("/managers/{agent}", status_code=204, dependencies=[needs(Role.ENGINEER)])
def close_manager(
    agent: Id,
    station: StationDep,
    force: bool = False,
) -> None:
    """Close a skill manager.

    Closes the skill manager of a subsystem: its skills are removed from the world model and from planning.

    Refused (409) while it is executing a module, unless `force` is true.

    Parameters:
        force: Stop its running modules first.
    """
    station.modules.close_manager(agent, force=force)


@router.get("/modules", dependencies=[needs(Role.VIEWER)])
def list_modules(station: StationDep) -> list[ModuleSummary]:
    """List all modules.

    Lists every skill and primitive once, with the subsystems that can run it.
    """
    return station.modules.all()


@router.get("/modules/{agent}/{module}", dependencies=[needs(Role.VIEWER)])
def get_module(agent: Id, module: Id, station: StationDep) -> ModuleDetails:
    """Describe a module.

    Returns its parameters with their JSON schemas, its conditions and its implementations; parameters for planning are
    marked.
    """
    return station.modules.get(agent, module)


@router.post("/modules/{agent}/{module}/panel", dependencies=[needs(Role.ENGINEER)])
def show_panel(agent: Id, module: Id, request: PanelRequest, station: StationDep) -> PanelInfo:
    """Check a module before it runs.

    Returns the arguments with which a module would run now, which of its conditions hold, and why the others do not;
    nothing is run.
    """
    return station.modules.panel(agent, module, request.arguments)


@router.post("/modules/{agent}/{module}/runs", status_code=202, dependencies=[needs(Role.ENGINEER)])
def run_module(
    agent: Id, module: Id, request: RunModule, station: StationDep, caller: CallerDep, response: Response
) -> ModuleRunInfo:
    """Run a single module.

    Starts a skill or primitive, as many times in a row as requested, and returns immediately.

    `Location` is the address of the run. The run waits for devices that are in use.
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

    Resets a module after a fault: data kept between runs is created again.
    """
    station.modules.reset(agent, module)


@router.get("/module-runs", dependencies=[needs(Role.VIEWER)])
def list_module_runs(
    station: StationDep,
    active: bool | None = None,
    limit: Annotated[int, Query(ge=1, le=1000)] = 100,
) -> ModuleRuns:
    """List runs of modules.

    Lists the runs started through the API, newest first; the last 200 ended runs are kept.

    Parameters:
        active: Only active runs, or only ended ones.
    """
    return station.modules.runs(active=active, limit=limit)


@router.get("/module-runs/{id}", dependencies=[needs(Role.VIEWER)])
def get_module_run(run: RunId, station: StationDep) -> ModuleRunInfo:
    """Get a run.

    Returns its progress, inferred arguments, reports, changes of the world, and outcome.
    """
    return station.modules.get_run(run)


@router.put("/module-runs/{id}/breakpoints", dependencies=[needs(Role.ENGINEER)])
def set_breakpoints(run: RunId, request: SetBreakpoints, station: StationDep) -> ModuleRunInfo:
    """Set breakpoints.

    Pauses a run before these nodes and no others; the command `resume` continues it.
    """
    return station.modules.set_breakpoints(run, request.paths)


@router.post("/module-runs/{id}/{command}", dependencies=[needs(Role.ENGINEER)])
def command_module_run(run: RunId, command: Command, station: StationDep) -> ModuleRunInfo:
    """Command a run.

    Pauses or resumes a run, executes one cycle of a paused run, or stops it immediately.
    """
    return station.modules.command_run(run, command)


@router.get("/skills", dependencies=[needs(Role.VIEWER)])
def list_skills(station: StationDep) -> list[SkillInfo]:
    """List the skills.

    Lists the available skills as people and planners see them: parameters, conditions, effects.
    """
    return station.modules.skills()


@router.get("/skills/{name}", dependencies=[needs(Role.VIEWER)])
def get_skill(name: Id, station: StationDep) -> SkillInfo:
    """Describe a skill.

    Returns a skill without its implementations.
    """
    return station.modules.skill(name)


plugins_router = APIRouter(tags=["plugins"])


@plugins_router.get("/plugins", dependencies=[needs(Role.ENGINEER)])
def list_plugins(station: StationDep) -> Plugins:
    """List the plug-ins.

    Lists every installed entry point, its distribution, and whether it works; determined when the server started.
    """
    return station.plugins.all()


@plugins_router.get("/plugins/faults", dependencies=[needs(Role.ENGINEER)])
def list_plugin_faults(station: StationDep) -> list[PluginFaultInfo]:
    """List broken plug-ins.

    Lists the plug-ins that do not load or do not fit the present scene, with the traceback for their authors.
    """
    return station.plugins.faults()
