"""Routes: skill managers, what they can run, and running it by itself."""

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
    RunModule,
    SkillInfo,
)
from skiros_py.errors import UnknownName, WrongState
from skiros_py.execution.skill_manager import SkillManager
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import found
from skiros_py.server.services import ServicesDep
from skiros_py.station.modules import views
from skiros_py.station.modules.runs import ModuleRun, Wish
from skiros_py.station.session import Session

__all__ = ["location_of", "manager_of", "router"]

router = APIRouter(tags=["modules"])

Id = Annotated[str, Path(max_length=200)]
Command = Literal["pause", "resume", "step", "stop"]


def manager_of(session: Session, agent: str, module: str) -> SkillManager:
    """Returns the skill manager of a subsystem that has a module; 404 where there is none."""
    with found("UnknownAgent"):
        if agent not in session.managers:
            raise UnknownName("skill manager", agent, session.managers)
    manager = session.managers[agent]
    with found("UnknownModule"):
        manager.info(module)
    return manager


def location_of(run: ModuleRun) -> str:
    """Returns where a run is followed."""
    return f"/api/v1/module-runs/{run.id}"


@router.get("/managers", summary="List the skill managers", dependencies=[needs(Role.VIEWER)])
def list_managers(services: ServicesDep) -> list[ManagerInfo]:
    """Every subsystem of a robot that can do something, what it runs now, and why nobody may count on it, if so."""
    return services.control.call(views.managers)


@router.get("/modules", summary="List all modules", dependencies=[needs(Role.VIEWER)])
def list_modules(services: ServicesDep) -> list[ModuleSummary]:
    """Every skill and primitive once, with the subsystems that can run it."""
    return services.control.call(views.modules)


@router.get("/modules/{agent}/{module}", summary="Describe a module", dependencies=[needs(Role.VIEWER)])
def get_module(agent: Id, module: Id, services: ServicesDep) -> ModuleDetails:
    """Parameters with JSON schema, conditions, and the ways of doing it; parameters for planning are marked."""
    return services.control.call(lambda session: views.module(manager_of(session, agent, module), module))


@router.post("/modules/{agent}/{module}/panel", summary="Look before it runs", dependencies=[needs(Role.ENGINEER)])
def show_panel(agent: Id, module: Id, request: PanelRequest, services: ServicesDep) -> PanelInfo:
    """What a module would be run with now, which of its conditions hold, and why the others do not; nothing runs."""

    def look(session: Session) -> PanelInfo:
        return views.panel(manager_of(session, agent, module), module, request.arguments)

    return services.control.call(look)


@router.post(
    "/modules/{agent}/{module}/runs",
    status_code=202,
    summary="Run a module by itself",
    dependencies=[needs(Role.ENGINEER)],
)
def run_module(
    agent: Id, module: Id, request: RunModule, services: ServicesDep, caller: CallerDep, response: Response
) -> ModuleRunInfo:
    """Starts a skill or primitive, so many times one after the other, and returns at once.

    It is answered where the run can be followed (`Location`). It waits for devices that something else uses.
    """
    wish = Wish(agent, module, request.arguments, caller.name, request.repeat)

    def start(session: Session) -> ModuleRun:
        manager_of(session, agent, module)
        return services.modules.start(session, wish)

    run = services.control.call(start)
    response.headers["Location"] = location_of(run)
    return views.run_info(run)


@router.post(
    "/modules/{agent}/{module}/reset", status_code=204, summary="Reset a module", dependencies=[needs(Role.ENGINEER)]
)
def reset_module(agent: Id, module: Id, services: ServicesDep) -> None:
    """Makes a module fit to run again after a fault: what it keeps between runs is made anew."""

    def reset(session: Session) -> None:
        manager = manager_of(session, agent, module)
        if module in manager.running:
            raise WrongState(f"{module} of {agent} is running: stop it first")
        manager.reset(module)

    services.control.call(reset)


@router.get("/module-runs", summary="List runs of modules", dependencies=[needs(Role.VIEWER)])
def list_module_runs(
    services: ServicesDep,
    active: Annotated[bool | None, Query(description="Only what is under way, or only what is over.")] = None,
    limit: Annotated[int, Query(ge=1, le=1000, description="So many at most.")] = 100,
) -> ModuleRuns:
    """What was started from outside, the youngest first; of what is over the last 200 are kept."""
    wanted = [run for run in services.modules.all() if active is None or active != run.over]
    return ModuleRuns(items=[views.run_info(run, in_full=False) for run in wanted[:limit]])


@router.get("/module-runs/{id}", summary="Follow a run", dependencies=[needs(Role.VIEWER)])
def get_module_run(id: Id, services: ServicesDep) -> ModuleRunInfo:  # noqa: A002 - as the address says it
    """How far it is, what was inferred, what it reported, what it wrote into the world, and what came of it."""
    with found():
        return views.run_info(services.modules.find(id))


@router.post("/module-runs/{id}/{command}", summary="Command a run", dependencies=[needs(Role.ENGINEER)])
def command_module_run(id: Id, command: Command, services: ServicesDep) -> ModuleRunInfo:  # noqa: A002
    """Pauses it where it stands, resumes it, lets it do one cycle while it is paused, or stops it at once."""
    with found():
        run = services.modules.find(id)
    services.control.call(lambda _session: run.command(command))
    return views.run_info(run)


@router.get("/skills", summary="List the skills", dependencies=[needs(Role.VIEWER)])
def list_skills(services: ServicesDep) -> list[SkillInfo]:
    """The skills that somebody offers now, as people and planners see them: parameters, conditions, effects."""
    return services.control.call(views.skills)


@router.get("/skills/{name}", summary="Describe a skill", dependencies=[needs(Role.VIEWER)])
def get_skill(name: Id, services: ServicesDep) -> SkillInfo:
    """One skill, apart from how it is done."""
    skills = {skill.name: skill for skill in services.control.call(views.skills)}
    with found():
        if name not in skills:
            raise UnknownName("skill", name, skills)
    return skills[name]
