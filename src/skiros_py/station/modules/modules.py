"""Use cases: skill managers, their modules, running single modules, and plug-ins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from skiros_py.api import modules as api
from skiros_py.catalogue import survey
from skiros_py.errors import UsageError, WrongState
from skiros_py.execution.runtime import agents_of
from skiros_py.execution.skill_manager import SkillManager
from skiros_py.messages import Message
from skiros_py.station.modules import views
from skiros_py.station.modules.runs import ModuleRun, Wish
from skiros_py.station.requests import LIBRARY, Author, Service, addressed, find
from skiros_py.station.session import Session


class ModuleService(Service):
    """Opens and closes skill managers, describes modules and runs single modules."""

    # ------------------------------------------------------------------ skill managers

    def managers(self) -> list[api.ManagerInfo]:
        """Lists the skill managers, each with the modules that it runs now, or why it is lost."""
        return self._call(views.managers)

    def open_manager(self, agent: str) -> api.ManagerInfo:
        """Opens the skill manager of a subsystem, which offers its skills from now on.

        Raises:
            NotFound: There is no such element.
            UsageError: It is neither a subsystem of a robot of this session nor a device without a robot.
            WrongState: Its skill manager is open already.
        """

        def do(session: Session) -> api.ManagerInfo:
            with addressed("UnknownAgent"):
                session.world.element(agent)
            if agent in session.managers and not session.managers[agent].lost:
                raise WrongState("the skill manager of {agent} is open already", agent=agent)
            agents = agents_of(session.world, session.spec)
            if agent not in agents:
                known = ", ".join(agents) or Message("none")
                raise UsageError(
                    "{agent} belongs to no robot of this session and is no device that acts; there is {known}",
                    agent=agent,
                    known=known,
                )
            session.managers.open(agent)
            return views.manager(session, session.managers[agent])

        return self._call(do)

    def close_manager(self, agent: str, *, force: bool = False) -> None:
        """Closes the skill manager of a subsystem; its skills are removed from the world model.

        Args:
            agent: Id of the subsystem.
            force: True to stop its running modules first.

        Raises:
            NotFound: It is not open.
            WrongState: It runs a module.
        """

        def do(session: Session) -> None:
            running = _manager(session, agent).running
            if running and not force:
                raise WrongState(
                    "{agent} runs {running}: stop that first, or force it",
                    agent=agent,
                    running=", ".join(sorted(running)),
                )
            session.managers.close(agent)

        self._call(do)

    # ------------------------------------------------------------------ modules

    def all(self) -> list[api.ModuleSummary]:
        """Lists every skill and primitive once, with the subsystems that can run it."""
        return self._call(views.modules)

    def get(self, agent: str, module: str) -> api.ModuleDetails:
        """Describes a module of a skill manager: parameters, conditions, implementations.

        Raises:
            NotFound: There is no such skill manager, or it has no such module.
        """
        return self._call(lambda session: views.module(_manager(session, agent, module), module))

    def panel(self, agent: str, module: str, arguments: Mapping[str, Any]) -> api.PanelInfo:
        """Returns the arguments with which a module would run now, and which of its conditions hold."""
        panel = self._call(lambda session: _manager(session, agent, module).panel(module, arguments))
        return api.PanelInfo.model_validate(panel.as_json())

    def run(
        self,
        agent: str,
        module: str,
        arguments: Mapping[str, Any],
        *,
        repeat: int = 1,
        author: Author = LIBRARY,
        breakpoints: Sequence[str] = (),
    ) -> api.ModuleRunInfo:
        """Starts a single skill or primitive, and returns immediately.

        Args:
            agent: Id of the subsystem.
            module: Name of the module.
            arguments: Its parameters; the others are inferred.
            repeat: Number of times to run it.
            author: The author of the request.
            breakpoints: Paths of nodes ("body/1") before which it is paused.

        Raises:
            NotFound: There is no such skill manager, or it has no such module.
            UsageError: The arguments are not valid.
            WrongState: It cannot be started now.
        """
        wish = Wish(agent, module, arguments, author.name, repeat, breakpoints=tuple(breakpoints))

        def start(session: Session) -> ModuleRun:
            _manager(session, agent, module)
            return self._station.module_runs.start(session, wish)

        return views.run_info(self._call(start))

    def reset(self, agent: str, module: str) -> None:
        """Resets a module after a fault, so that it can run again.

        Raises:
            NotFound: There is no such skill manager, or it has no such module.
            WrongState: It is running.
        """

        def do(session: Session) -> None:
            manager = _manager(session, agent, module)
            if module in manager.running:
                raise WrongState("{module} of {agent} is running: stop it first", module=module, agent=agent)
            manager.reset(module)

        self._call(do)

    # ------------------------------------------------------------------ runs

    def runs(self, *, active: bool | None = None, limit: int = 100) -> api.ModuleRuns:
        """Lists runs of modules, newest first.

        Args:
            active: True for active runs only, False for ended runs only.
            limit: Maximum number of runs.
        """
        wanted = [run for run in self._station.module_runs.all() if active is None or active != run.over]
        return api.ModuleRuns(items=[views.run_info(run, in_full=False) for run in wanted[:limit]])

    def get_run(self, id_: str) -> api.ModuleRunInfo:
        """Describes a run: progress, inferred arguments, changes of the world, outcome.

        Raises:
            NotFound: There is none with this id.
        """
        return views.run_info(self._station.module_runs.find(id_))

    def command_run(self, id_: str, command: api.RunCommand) -> api.ModuleRunInfo:
        """Pauses, resumes or stops a run, or executes one cycle of a paused run.

        Raises:
            NotFound: There is none with this id.
            WrongState: It does not accept that command now.
        """
        run = self._station.module_runs.find(id_)
        self._call(lambda _session: run.command(command))
        return views.run_info(run)

    def set_breakpoints(self, id_: str, paths: Sequence[str]) -> api.ModuleRunInfo:
        """Sets the breakpoints of a run: it is paused before these nodes until a command resumes it.

        Args:
            id_: Its id.
            paths: Paths of nodes ("body/1") as in the description of the module.

        Raises:
            NotFound: There is no such run.
        """
        run = self._station.module_runs.find(id_)
        self._call(lambda _session: run.set_breakpoints(paths))
        return views.run_info(run)

    # ------------------------------------------------------------------ skills

    def skills(self) -> list[api.SkillInfo]:
        """Lists the offered skills as planners see them: parameters, conditions, effects."""
        return self._call(views.skills)

    def skill(self, name: str) -> api.SkillInfo:
        """Describes one skill, without its implementations.

        Raises:
            NotFound: No skill with this name is offered.
        """
        return find("skill", name, {skill.name: skill for skill in self.skills()})


def _manager(session: Session, agent: str, module: str = "") -> SkillManager:
    manager = find("skill manager", agent, session.managers, "UnknownAgent")
    if module:
        with addressed("UnknownModule"):
            manager.info(module)
    return manager


class PluginService(Service):
    """Lists plug-ins."""

    def all(self) -> api.Plugins:
        """Lists every installed entry point, and whether it works."""
        return _surveyed()

    def faults(self) -> list[api.PluginFaultInfo]:
        """Lists the plug-ins that do not load or do not fit the current scene."""
        return list(map(api.PluginFaultInfo.view_of, self._session.catalogue.faults))


@cache
def _surveyed() -> api.Plugins:
    """Loads all entry points, once: the installation does not change while a program runs."""
    found, others = survey()
    return api.Plugins(items=list(map(views.plugin, found)), others=list(map(api.PluginFaultInfo.view_of, others)))
