"""Use cases: skill managers, what they can run, and running it by itself."""

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
    SkillInfo,
)
from skiros_py.errors import UnknownName, UsageError, WrongState
from skiros_py.execution.managers import agents_of
from skiros_py.execution.skill_manager import SkillManager
from skiros_py.station.modules import views
from skiros_py.station.modules.runs import ModuleRun, Wish
from skiros_py.station.requests import LIBRARY, Author, Service, addressed
from skiros_py.station.session import Session


class ModuleService(Service):
    """Opens and closes skill managers, describes modules and runs them by themselves."""

    # ------------------------------------------------------------------ skill managers

    def managers(self) -> list[ManagerInfo]:
        """Lists the skill managers, with what each runs now, or why it is lost."""
        return self._station.control.call(views.managers)

    def open_manager(self, agent: str) -> ManagerInfo:
        """Opens the skill manager of a subsystem: its skills are on offer from now on.

        Raises:
            NotFound: There is no such element.
            UsageError: It is neither a subsystem of a robot of this session nor a device without a robot.
            WrongState: Its skill manager is open already.
        """

        def do(session: Session) -> ManagerInfo:
            with addressed("UnknownAgent"):
                session.world.element(agent)
            if agent in session.managers and not session.managers[agent].lost:
                raise WrongState(f"the skill manager of {agent} is open already")
            agents = agents_of(session.world, session.spec)
            if agent not in agents:
                there = f"and is no device that acts; there is {', '.join(agents) or 'none'}"
                raise UsageError(f"{agent} belongs to no robot of this session {there}")
            session.managers.open(agent)
            return views.manager(session, session.managers[agent])

        return self._station.control.call(do)

    def close_manager(self, agent: str, *, force: bool = False) -> None:
        """Closes the skill manager of a subsystem: its skills leave the world model.

        Args:
            agent: Id of the subsystem.
            force: True to stop first what it runs.

        Raises:
            NotFound: It is not open.
            WrongState: It runs something.
        """

        def do(session: Session) -> None:
            running = _manager(session, agent).running
            if running and not force:
                raise WrongState(f"{agent} runs {', '.join(sorted(running))}: stop that first, or force it")
            session.managers.close(agent)

        self._station.control.call(do)

    # ------------------------------------------------------------------ modules

    def all(self) -> list[ModuleSummary]:
        """Lists every skill and primitive once, with the subsystems that can run it."""
        return self._station.control.call(views.modules)

    def get(self, agent: str, module: str) -> ModuleDetails:
        """Describes a module of a skill manager: parameters, conditions, implementations.

        Raises:
            NotFound: There is no such skill manager, or it has no such module.
        """
        return self._station.control.call(lambda session: views.module(_manager(session, agent, module), module))

    def panel(self, agent: str, module: str, arguments: Mapping[str, Any]) -> PanelInfo:
        """Tells with which arguments a module would run now, and which of its conditions hold; nothing runs."""
        return self._station.control.call(
            lambda session: views.panel(_manager(session, agent, module), module, arguments)
        )

    def run(
        self,
        agent: str,
        module: str,
        arguments: Mapping[str, Any],
        *,
        repeat: int = 1,
        author: Author = LIBRARY,
        breakpoints: Sequence[str] = (),
    ) -> ModuleRunInfo:
        """Starts a skill or primitive by itself, and returns at once.

        Args:
            agent: Id of the subsystem.
            module: Name of the module.
            arguments: Its parameters; the others are inferred.
            repeat: How often.
            author: Who asks.
            breakpoints: Paths of nodes ("body/1") before which it is paused.

        Raises:
            NotFound: There is no such skill manager, or it has no such module.
            UsageError: Something is wrong with the arguments.
            WrongState: It cannot be started now.
        """
        wish = Wish(agent, module, arguments, author.name, repeat, breakpoints=tuple(breakpoints))

        def start(session: Session) -> ModuleRun:
            _manager(session, agent, module)
            return self._station.module_runs.start(session, wish)

        return views.run_info(self._station.control.call(start))

    def reset(self, agent: str, module: str) -> None:
        """Makes a module fit to run again after a fault.

        Raises:
            NotFound: There is no such skill manager, or it has no such module.
            WrongState: It is running.
        """

        def do(session: Session) -> None:
            manager = _manager(session, agent, module)
            if module in manager.running:
                raise WrongState(f"{module} of {agent} is running: stop it first")
            manager.reset(module)

        self._station.control.call(do)

    # ------------------------------------------------------------------ runs

    def runs(self, *, active: bool | None = None, limit: int = 100) -> ModuleRuns:
        """Lists runs of modules, the youngest first.

        Args:
            active: True for those under way only, False for those that are over only.
            limit: How many at most.
        """
        wanted = [run for run in self._station.module_runs.all() if active is None or active != run.over]
        return ModuleRuns(items=[views.run_info(run, in_full=False) for run in wanted[:limit]])

    def get_run(self, id_: str) -> ModuleRunInfo:
        """Describes a run: progress, inferred arguments, changes of the world, outcome.

        Raises:
            NotFound: There is none of that id.
        """
        return views.run_info(self._find(id_))

    def command_run(self, id_: str, command: Literal["pause", "resume", "step", "stop"]) -> ModuleRunInfo:
        """Pauses a run, resumes it, lets it do one cycle while it is paused, or stops it.

        Raises:
            NotFound: There is none of that id.
            WrongState: It does not take that command now.
        """
        run = self._find(id_)
        self._station.control.call(lambda _session: run.command(command))
        return views.run_info(run)

    def set_breakpoints(self, id_: str, paths: Sequence[str]) -> ModuleRunInfo:
        """Pauses a run before these nodes and no others; a command resumes it.

        Args:
            id_: Its id.
            paths: Paths of nodes ("body/1"), as a module's description has them.

        Raises:
            NotFound: There is no such run.
        """
        run = self._find(id_)
        self._station.control.call(lambda _session: run.set_breakpoints(paths))
        return views.run_info(run)

    def _find(self, id_: str) -> ModuleRun:
        with addressed():
            return self._station.module_runs.find(id_)

    # ------------------------------------------------------------------ skills

    def skills(self) -> list[SkillInfo]:
        """Lists the skills on offer as planners see them: parameters, conditions, effects."""
        return self._station.control.call(views.skills)

    def skill(self, name: str) -> SkillInfo:
        """Describes one skill, apart from its implementations.

        Raises:
            NotFound: There is none of that name on offer.
        """
        skills = {skill.name: skill for skill in self.skills()}
        with addressed():
            if name not in skills:
                raise UnknownName("skill", name, skills)
        return skills[name]


def _manager(session: Session, agent: str, module: str = "") -> SkillManager:
    with addressed("UnknownAgent"):
        if agent not in session.managers:
            raise UnknownName("skill manager", agent, session.managers)
    manager = session.managers[agent]
    if module:
        with addressed("UnknownModule"):
            manager.info(module)
    return manager
