"""Routes: skill managers, modules and their runs, plug-ins."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path, Query

from skiros_py.api import modules as api
from skiros_py.server.access.roles import Engineer, Viewer
from skiros_py.server.problems import topic_router

router = topic_router("modules")

Id = Annotated[str, Path(max_length=200)]
RunId = Annotated[str, Path(alias="id", max_length=200)]


@router.get("/managers")
def list_managers(act: Viewer) -> api.Managers:
    """List the skill managers.

    Lists the subsystems that can execute modules, what each is executing, and why it is lost, if it is.
    """
    return api.Managers(items=act.station.modules.managers())


@router.put("/managers/{agent}")
def open_manager(act: Engineer, agent: Id) -> api.ManagerInfo:
    """Open a skill manager.

    Opens the skill manager of a subsystem, for example one that was closed or lost: its skills become available again.
    """
    return act.station.modules.open_manager(agent)


@router.delete("/managers/{agent}", status_code=204)
def close_manager(
    act: Engineer,
    agent: Id,
    force: bool = False,
) -> None:
    """Close a skill manager.

    Closes the skill manager of a subsystem: its skills are removed from the world model and from planning.

    Refused (409) while it is executing a module, unless `force` is true.

    Parameters:
        force: Stop its running modules first.
    """
    act.station.modules.close_manager(agent, force=force)


@router.get("/modules")
def list_modules(act: Viewer) -> api.Modules:
    """List all modules.

    Lists every skill and primitive once, with the subsystems that can run it.
    """
    return api.Modules(items=act.station.modules.all())


@router.get("/modules/{agent}/{module}")
def get_module(act: Viewer, agent: Id, module: Id) -> api.ModuleDetails:
    """Describe a module.

    Returns its parameters with their JSON schemas, its conditions and its implementations; parameters for planning are
    marked.
    """
    return act.station.modules.get(agent, module)


@router.post("/modules/{agent}/{module}/panel")
def show_panel(act: Engineer, agent: Id, module: Id, request: api.PanelRequest) -> api.PanelInfo:
    """Check a module before it runs.

    Returns the arguments with which a module would run now, which of its conditions hold, and why the others do not;
    nothing is run.
    """
    return act.station.modules.panel(agent, module, request.arguments)


@router.post("/modules/{agent}/{module}/runs", status_code=202)
def run_module(act: Engineer, agent: Id, module: Id, request: api.RunModule) -> api.ModuleRunInfo:
    """Run a single module.

    Starts a skill or primitive, as many times in a row as requested, and returns immediately.

    `Location` is the address of the run. The run waits for devices that are in use.
    """
    run = act.station.modules.run(
        agent,
        module,
        request.arguments,
        repeat=request.repeat,
        author=act.author,
        breakpoints=request.breakpoints,
    )
    act.locate("module-runs", run.id)
    return run


@router.post("/modules/{agent}/{module}/reset", status_code=204)
def reset_module(act: Engineer, agent: Id, module: Id) -> None:
    """Reset a module.

    Resets a module after a fault: data kept between runs is created again.
    """
    act.station.modules.reset(agent, module)


@router.get("/module-runs")
def list_module_runs(
    act: Viewer,
    active: bool | None = None,
    limit: Annotated[int, Query(ge=1, le=1000)] = 100,
) -> api.ModuleRuns:
    """List runs of modules.

    Lists the runs started through the API, newest first; the last 200 ended runs are kept.

    Parameters:
        active: Only active runs, or only ended ones.
    """
    return act.station.modules.runs(active=active, limit=limit)


@router.get("/module-runs/{id}")
def get_module_run(act: Viewer, run: RunId) -> api.ModuleRunInfo:
    """Get a run.

    Returns its progress, inferred arguments, reports, changes of the world, and outcome.
    """
    return act.station.modules.get_run(run)


@router.put("/module-runs/{id}/breakpoints")
def set_breakpoints(act: Engineer, run: RunId, request: api.SetBreakpoints) -> api.ModuleRunInfo:
    """Set breakpoints.

    Pauses a run before these nodes and no others; the command `resume` continues it.
    """
    return act.station.modules.set_breakpoints(run, request.paths)


@router.post("/module-runs/{id}/{command}")
def command_module_run(act: Engineer, run: RunId, command: api.RunCommand) -> api.ModuleRunInfo:
    """Command a run.

    Pauses or resumes a run, executes one cycle of a paused run, or stops it immediately.
    """
    return act.station.modules.command_run(run, command)


@router.get("/skills")
def list_skills(act: Viewer) -> api.Skills:
    """List the skills.

    Lists the available skills as people and planners see them: parameters, conditions, effects.
    """
    return api.Skills(items=act.station.modules.skills())


@router.get("/skills/{name}")
def get_skill(act: Viewer, name: Id) -> api.SkillInfo:
    """Describe a skill.

    Returns a skill without its implementations.
    """
    return act.station.modules.skill(name)


plugins_router = topic_router("plugins")


@plugins_router.get("/plugins")
def list_plugins(act: Engineer) -> api.Plugins:
    """List the plug-ins.

    Lists every installed entry point, its distribution, and whether it works; determined when the server started.
    """
    return act.station.plugins.all()


@plugins_router.get("/plugins/faults")
def list_plugin_faults(act: Engineer) -> api.PluginFaults:
    """List broken plug-ins.

    Lists the plug-ins that do not load or do not fit the current scene, with the traceback for their authors.
    """
    return api.PluginFaults(items=act.station.plugins.faults())
