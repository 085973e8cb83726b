"""Modules: the skills and primitives of the skill managers, individual runs, and plug-ins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

from skiros_py.api.modules import (
    ManagerInfo,
    ModuleDetails,
    ModuleRunInfo,
    ModuleRuns,
    ModuleSummary,
    PanelInfo,
    PluginFaultInfo,
    Plugins,
    SkillInfo,
)
from skiros_py.client.request import Call, nothing, path_of


def list_managers() -> Call[list[ManagerInfo]]:
    """Lists the skill managers, with their skills and current runs."""
    return Call("GET", "/managers", list[ManagerInfo])


def open_manager(agent: str) -> Call[ManagerInfo]:
    """Opens the skill manager of a subsystem: its skills become available."""
    return Call("PUT", path_of("managers", agent), ManagerInfo, repeatable=False)


def close_manager(agent: str, *, force: bool | None = None) -> Call[None]:
    """Closes the skill manager of a subsystem: its skills leave the world model."""
    query = {"force": None if force is None else str(force).lower()}
    return Call("DELETE", path_of("managers", agent), nothing, query=query, repeatable=False)


def list_modules() -> Call[list[ModuleSummary]]:
    """Lists every skill and primitive with the agents that can run it."""
    return Call("GET", "/modules", list[ModuleSummary])


def get_module(agent: str, module: str) -> Call[ModuleDetails]:
    """Returns a module of a subsystem."""
    return Call("GET", path_of("modules", agent, module), ModuleDetails)


def show_panel(agent: str, module: str, arguments: Mapping[str, Any] | None = None) -> Call[PanelInfo]:
    """Returns the arguments a module would be run with now, and which of its conditions hold; nothing is run."""
    body = {"arguments": dict(arguments or {})}
    return Call("POST", path_of("modules", agent, module, "panel"), PanelInfo, json=body)


def run_module(
    agent: str,
    module: str,
    arguments: Mapping[str, Any] | None = None,
    *,
    repeat: int = 1,
    breakpoints: Sequence[str] = (),
) -> Call[ModuleRunInfo]:
    """Starts a single module; follow it with :func:`get_module_run`."""
    body = {"arguments": dict(arguments or {}), "repeat": repeat, "breakpoints": list(breakpoints)}
    return Call("POST", path_of("modules", agent, module, "runs"), ModuleRunInfo, json=body, repeatable=False)


def reset_module(agent: str, module: str) -> Call[None]:
    """Resets a module after a fault."""
    return Call("POST", path_of("modules", agent, module, "reset"), nothing)


def list_module_runs(*, active: bool | None = None, limit: int | None = None) -> Call[ModuleRuns]:
    """Lists the runs started through the API, newest first."""
    query = {"active": None if active is None else str(active).lower(), "limit": limit}
    return Call("GET", "/module-runs", ModuleRuns, query=query)


def get_module_run(run: str) -> Call[ModuleRunInfo]:
    """Returns the progress or result of a run."""
    return Call("GET", path_of("module-runs", run), ModuleRunInfo)


def set_breakpoints(run: str, paths: Sequence[str]) -> Call[ModuleRunInfo]:
    """Sets the nodes before which a run pauses, replacing earlier ones; the command "resume" continues it."""
    return Call("PUT", path_of("module-runs", run, "breakpoints"), ModuleRunInfo, json={"paths": list(paths)})


def command_module_run(run: str, command: Literal["pause", "resume", "step", "stop"]) -> Call[ModuleRunInfo]:
    """Pauses, resumes, single-steps (one cycle) or stops a run."""
    path = path_of("module-runs", run, command)
    return Call("POST", path, ModuleRunInfo, repeatable=command != "step")


def list_skills() -> Call[list[SkillInfo]]:
    """Lists the currently available skills."""
    return Call("GET", "/skills", list[SkillInfo])


def get_skill(name: str) -> Call[SkillInfo]:
    """Returns the description of a skill, without its implementation."""
    return Call("GET", path_of("skills", name), SkillInfo)


def list_plugins() -> Call[Plugins]:
    """Lists all entry points installed on the server."""
    return Call("GET", "/plugins", Plugins)


def list_plugin_faults() -> Call[list[PluginFaultInfo]]:
    """Lists plug-ins that fail to load or do not fit the current scene."""
    return Call("GET", "/plugins/faults", list[PluginFaultInfo])
