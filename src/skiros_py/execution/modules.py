"""What a skill manager can run: primitives and skills by name, loaded when they are first wanted."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from skiros_py.errors import ModuleError, UnknownName, UsageError
from skiros_py.execution.claims import Claim, Claims
from skiros_py.execution.contained import contained, words
from skiros_py.execution.primitive_run import Loaded, run_primitive
from skiros_py.execution.pulse import CycleOverrun
from skiros_py.execution.scope import Scope
from skiros_py.execution.skill_run import SkillRun
from skiros_py.robot.devices import DeviceBoard
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import BROKEN, Failure, Outcome
from skiros_py.skills.parameters import Kind, Param, params_of, read_value
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill

__all__ = ["ModuleInfo", "Modules"]

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ModuleInfo:
    """One module, for people who choose one.

    Attributes:
        name: Its name.
        kind: "skill" or "primitive".
        help: One sentence.
        params: Its parameters.
        version: Version of the (first) implementation.
        implementations: Labels of a skill's implementations, in the order in which they are tried.
    """

    name: str
    kind: str
    help: str
    params: tuple[Param, ...]
    version: str
    implementations: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data; planning parameters are left out, people never see them."""
        shown = [p for p in self.params if p.kind is not Kind.PLANNING]
        return {
            "name": self.name,
            "kind": self.kind,
            "help": self.help,
            "version": self.version,
            "implementations": list(self.implementations),
            "parameters": [
                {"key": p.key, "type": p.type_name, "kind": p.kind.value, "help": p.help, "unit": p.unit} for p in shown
            ],
        }


class Modules:
    """The modules of one skill manager.

    Args:
        agent: Id of the subsystem.
        skills: Implementations of each skill by its name, in the order in which they are tried.
        primitives: Classes by name; may load themselves when they are looked up.
        claims: Who may use which device.
        board: Whose commands are limited to what was taken.
        config: Values of configuration parameters by "module.key".
    """

    def __init__(
        self,
        agent: str,
        skills: Mapping[str, Sequence[Skill]],
        primitives: Mapping[str, type[Primitive[Any]]],
        claims: Claims,
        board: DeviceBoard,
        config: Mapping[str, Any],
    ) -> None:
        self._agent = agent
        self.skills = skills
        self.primitives = primitives
        self._claims = claims
        self._board = board
        self._config = config
        self._loaded: dict[str, Loaded] = {}

    def kind(self, module: str) -> str:
        """Returns "skill" or "primitive".

        Raises:
            UnknownName: There is no such module.
        """
        if module in self.skills:
            return "skill"
        if module in self.primitives:
            return "primitive"
        raise UnknownName("module", module, [*self.skills, *self.primitives], where=f"of {self._agent}")

    def info(self, module: str) -> ModuleInfo:
        """Describes one module.

        Raises:
            UnknownName: There is no such module.
        """
        if self.kind(module) == "skill":
            ways = self.skills[module]
            first, labels = ways[0], tuple(skill.label for skill in ways)
            return ModuleInfo(module, "skill", first.description.help, first.description.params, first.version, labels)
        cls = self.primitives[module]
        help_ = (cls.__doc__ or "").strip().partition("\n")[0]
        return ModuleInfo(module, "primitive", help_, params_of(cls.Params), cls.version)

    def run(self, module: str, arguments: Mapping[str, Any], scope: Scope) -> Execution[Outcome]:
        """Returns the run of a module within a scope; ticked to its end, or closed.

        Raises:
            UnknownName: There is no such module.
        """
        if self.kind(module) == "skill":
            return self.skill_run(module, arguments, scope).execute()
        try:
            loaded = self._load(module, scope.context)
        except (KeyboardInterrupt, CycleOverrun, UnknownName, UsageError):
            raise
        except BaseException as error:  # noqa: BLE001 - an author's mistake makes this run fail, and no other
            _log.exception("primitive %s did not load", module)
            return _failed(Failure(f"{module} did not load: {words(error)}", BROKEN))
        return run_primitive(loaded, arguments, scope, self.take)

    def skill_run(self, skill: str, arguments: Mapping[str, Any], scope: Scope) -> SkillRun:
        """Makes a run of a skill."""
        return SkillRun(self.skills[skill], arguments, scope, self.take)

    def take(self, owner: str, devices: set[str], within: Claim | None) -> Claim:
        """Asks for devices, out of those of the module around it."""
        claim = self._claims.request(owner, devices, within=within)
        task = self._board.owner
        if within is None and task is not None:
            task.devices = claim.devices
        return claim

    def reset(self, module: str, context: RunContext) -> None:
        """Makes a primitive fit to run again after a fault; where that fails, it is loaded anew for the next run.

        Raises:
            ModuleError: Its code broke.
        """
        loaded = self._loaded.pop(module, None)
        if loaded is None:
            return
        resource = contained(f"{module}, when it was reset,", lambda: (loaded.cls.reset(context, loaded.resource),))
        if isinstance(resource, Failure):
            raise ModuleError(resource.reason)
        self._loaded[module] = replace(loaded, resource=resource[0])

    def _load(self, module: str, context: RunContext) -> Loaded:
        if module not in self._loaded:
            cls = self.primitives[module]
            self._loaded[module] = Loaded(cls, self._configuration(module, cls, context), cls.load(context))
        return self._loaded[module]

    def _configuration(self, module: str, cls: type[Primitive[Any]], context: RunContext) -> dict[str, Any]:
        """Reads what is given for the configuration parameters of a primitive."""
        given = {k.partition(".")[2]: v for k, v in self._config.items() if k.partition(".")[0] == module}
        params = {p.key: p for p in params_of(cls.Params) if p.kind is Kind.CONFIG}
        for key in given:
            if key not in params:
                raise UnknownName("configuration parameter", key, params, where=f"of {module}")
        return {key: read_value(params[key], value, context.world) for key, value in given.items()}


def _failed(failure: Failure) -> Execution[Outcome]:
    yield from ()
    return failure
