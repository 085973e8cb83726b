"""Jogging and teaching: the modules that the kind of a device names for that, started by a person."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

from skiros_py.api.robots import DeviceModule
from skiros_py.errors import UnknownName, UsageError, WrongState
from skiros_py.execution.claims import pieces
from skiros_py.skills.surroundings import owner
from skiros_py.station.modules.runs import ModuleRun, ModuleRuns, Wish
from skiros_py.station.session import Session
from skiros_py.tasks.handle import TaskHandle

Verb = Literal["jog", "teach"]


def device_modules(session: Session, device: str, names: Sequence[str]) -> tuple[DeviceModule, ...]:
    """Returns modules for a device, each with the subsystem that would run it."""
    return tuple(DeviceModule(module=name, agent=_agent(session, device, name)) for name in names)


def start_by_hand(
    session: Session, runs: ModuleRuns, device: str, verb: Verb, module: str | None, given: Mapping[str, Any], by: str
) -> ModuleRun:
    """Starts a module with which a device is jogged, or taught with; to be called in the control thread.

    Args:
        session: The session.
        runs: Follows the run.
        device: Id of the device.
        verb: The purpose.
        module: A module that the kind of the device names for it; None for the first.
        given: Arguments of the module; the device is filled in.
        by: Name of the person.

    Raises:
        UsageError: The kind names no such module, no subsystem can run it, or the arguments are not valid.
        WrongState: The device is in use, or everything is halted.
    """
    spec = session.spec.devices[device]
    names: tuple[str, ...] = getattr(spec, verb)
    if not names:
        raise UsageError(f"{device}: devices of kind '{spec.kind}' have no module to {verb}")
    if module is not None and module not in names:
        raise UnknownName("module", module, names, where=f"to {verb} {device}")
    module = module or names[0]
    agent = _agent(session, device, module)
    if agent is None:
        raise UsageError(f"no subsystem that could {verb} {device} has the module {module}")
    if busy := _at_work(session, agent):
        raise WrongState(f"{device} cannot be moved by hand, {busy} is active: wait, or pause or stop that")
    arguments = {**given, **_named(session, agent, module, device, given)}
    return runs.start(session, Wish(agent, module, arguments, by, at_once=True))


def _agent(session: Session, device: str, module: str) -> str | None:
    """Returns the subsystem that runs a module for a device; None for none.

    That is the device itself, else a subsystem that has it, else another one of its robot. For a device without a
    robot it may be any.
    """
    view = session.world.snapshot()
    robot = owner(view, device)
    near = [agent for agent in sorted(session.managers) if view.has(agent) and robot in (None, owner(view, agent))]
    able = [agent for agent in near if (manager := session.managers.get(agent)) and module in manager.modules]
    return min(able, key=lambda agent: (agent != device, device not in pieces(view, agent)), default=None)


def _named(session: Session, agent: str, module: str, device: str, given: Mapping[str, Any]) -> dict[str, str]:
    """Returns the parameter that takes the device: the first of its class.

    Raises:
        UsageError: Another device is given for it.
    """
    view = session.world.snapshot()
    type_ = view.element(device).type
    for param in session.managers[agent].info(module).params:
        if param.is_element and view.ontology.is_a(type_, param.element_class):
            if given.get(param.key) not in (None, device):
                raise UsageError(f"{param.key}: it is {device} here, not {given[param.key]}")
            return {param.key: device}
    return {}


def _at_work(session: Session, agent: str) -> str:
    """Returns the activity of a subsystem or its robot; empty if it waits for a person, or is paused between steps."""
    view = session.world.snapshot()
    robot = owner(view, agent)
    agents = [a for a in sorted(session.managers) if a == agent or (robot and view.has(a) and owner(view, a) == robot)]
    running = [f"{name} of {a}" for a in agents for name in session.managers[a].running]
    tasks = [task.name for task in session.tasks.active if _may_move(task, agents)]
    return ", ".join([*running, *tasks])


def _may_move(task: TaskHandle, agents: Sequence[str]) -> bool:
    if task.status not in ("planning", "running"):
        return False
    return task.plan is None or any(set(step.arguments.values()) & set(agents) for step in task.plan.steps)
