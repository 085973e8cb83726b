"""Modules: what the skill managers can run, running it by itself, and the plug-ins they come from."""

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
from skiros_py.client.call import Call, nothing, path_of


def list_managers() -> Call[list[ManagerInfo]]:
    """Lists the skill managers, with what each can do and what it runs."""
    return Call("GET", "/managers", list[ManagerInfo])


def open_manager(agent: str) -> Call[ManagerInfo]:
    """Opens the skill manager of a subsystem: its skills are on offer from now on."""
    return Call("PUT", path_of("managers", agent), ManagerInfo, repeatable=False)


def close_manager(agent: str, *, force: bool | None = None) -> Call[None]:
    """Closes the skill manager of a subsystem: its skills leave the world model."""
    query = {"force": None if force is None else str(force).lower()}
    return Call("DELETE", path_of("managers", agent), nothing, query=query, repeatable=False)


def list_modules() -> Call[list[ModuleSummary]]:
    """Lists every skill and primitive with who can run it."""
    return Call("GET", "/modules", list[ModuleSummary])


def get_module(agent: str, module: str) -> Call[ModuleDetails]:
    """Describes a module of a subsystem."""
    return Call("GET", path_of("modules", agent, module), ModuleDetails)


def show_panel(agent: str, module: str, arguments: Mapping[str, Any] | None = None) -> Call[PanelInfo]:
    """Returns what a module would be run with now, and which of its conditions hold; nothing runs."""
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
    """Starts a module by itself; follow it with :func:`get_module_run`."""
    body = {"arguments": dict(arguments or {}), "repeat": repeat, "breakpoints": list(breakpoints)}
    return Call("POST", path_of("modules", agent, module, "runs"), ModuleRunInfo, json=body, repeatable=False)


def reset_module(agent: str, module: str) -> Call[None]:
    """Makes a module fit to run again after a fault."""
    return Call("POST", path_of("modules", agent, module, "reset"), nothing)


def list_module_runs(*, active: bool | None = None, limit: int | None = None) -> Call[ModuleRuns]:
    """Lists what was started from outside, the youngest first."""
    query = {"active": None if active is None else str(active).lower(), "limit": limit}
    return Call("GET", "/module-runs", ModuleRuns, query=query)


def get_module_run(run: str) -> Call[ModuleRunInfo]:
    """Returns how far a run is, or what came of it."""
    return Call("GET", path_of("module-runs", run), ModuleRunInfo)


def set_breakpoints(run: str, paths: Sequence[str]) -> Call[ModuleRunInfo]:
    """Pauses a run before these nodes and no others; the command "resume" lets it go on."""
    return Call("PUT", path_of("module-runs", run, "breakpoints"), ModuleRunInfo, json={"paths": list(paths)})


def command_module_run(run: str, command: Literal["pause", "resume", "step", "stop"]) -> Call[ModuleRunInfo]:
    """Pauses a run, resumes it, lets it do one cycle, or stops it."""
    path = path_of("module-runs", run, command)
    return Call("POST", path, ModuleRunInfo, repeatable=command != "step")


def list_skills() -> Call[list[SkillInfo]]:
    """Lists the skills that somebody offers now."""
    return Call("GET", "/skills", list[SkillInfo])


def get_skill(name: str) -> Call[SkillInfo]:
    """Describes a skill, apart from how it is done."""
    return Call("GET", path_of("skills", name), SkillInfo)


def list_plugins() -> Call[Plugins]:
    """Lists every entry point that is installed where the server runs."""
    return Call("GET", "/plugins", Plugins)


def list_plugin_faults() -> Call[list[PluginFaultInfo]]:
    """Lists what does not load or fit into the present scene."""
    return Call("GET", "/plugins/faults", list[PluginFaultInfo])
