"""What a skill manager can run: primitives, skills and documents by name, also those of other managers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from skiros_py.errors import DescriptionError, UnknownName
from skiros_py.execution.claims import Claim, Claims
from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.loader import Loader
from skiros_py.execution.monitor import Monitor
from skiros_py.execution.primitive_run import PrimitiveRun
from skiros_py.execution.running import BehaviourRun, RunnableDocument
from skiros_py.execution.scope import Scope, failed
from skiros_py.execution.skill_run import SkillRun
from skiros_py.skills.behaviour import calls_of
from skiros_py.skills.conditions.watch import Watches
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.skills.parameters import Access, Kind, Output, Param, params_of
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.skills.surroundings import owner


@dataclass(frozen=True, slots=True)
class ModuleInfo:
    """One module, for people who choose one.

    Attributes:
        name: Its name.
        kind: "skill", "primitive" or "document".
        help: One sentence.
        params: Its parameters.
        version: Version of the (first) implementation.
        implementations: Labels of a skill's implementations, in the order in which they are tried.
        outputs: The values that its outcome has; none of a skill.
    """

    name: str
    kind: str
    help: str
    params: tuple[Param, ...]
    version: str
    implementations: tuple[str, ...] = ()
    outputs: tuple[Output, ...] = ()

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
            "outputs": [
                {"name": o.name, "type": o.param.type_name, "help": o.help, "unit": o.unit} for o in self.outputs
            ],
        }


@dataclass(frozen=True, slots=True)
class CellModules:
    """What the skill managers of a cell share.

    Attributes:
        skills: All skills found.
        primitives: All primitives found, by name; they may load themselves when they are looked up.
        context: World, devices, adapters.
        cycle: Runs everything.
        monitor: Takes module events.
        watches: Conditions under watch.
        driver: Kind of cell driver; a fake one gets the implementations that only pretend.
        config: Values of configuration parameters by "module.key".
        claims: Who may use which device.
        documents: Documents that every manager runs as modules, by name; they may be exchanged at any time.
        offers: The modules of each subsystem that is there, by its id; for any thread.
    """

    skills: Sequence[Skill]
    primitives: Mapping[str, type[Primitive[Any]]]
    context: RunContext
    cycle: ControlCycle
    monitor: Monitor
    watches: Watches
    driver: str
    config: Mapping[str, Any]
    claims: Claims = field(default_factory=Claims)
    documents: dict[str, RunnableDocument] = field(default_factory=dict)
    offers: dict[str, Modules] = field(default_factory=dict)

    def who_runs(self, module: str, arguments: Mapping[str, Any], caller: Modules) -> Modules:
        """Returns the modules of the subsystem that runs a called one.

        That is the subsystem that the arguments name, else the caller itself, else one of the caller's robot, else the
        first by its id; the caller for a module that is offered nowhere as a skill.
        """
        view = self.context.world
        able = [offer for offer in tuple(self.offers.values()) if module in offer.skills]
        robot = owner(view, caller.agent)

        def far(offer: Modules) -> tuple[bool, bool, bool, str]:
            named = arguments.get(offer.skills[module][0].description.agent) == offer.agent
            return not named, offer is not caller, owner(view, offer.agent) != robot, offer.agent

        return min(able, key=far, default=caller)


class Modules:
    """The modules of one skill manager.

    Args:
        agent: Id of the subsystem.
        skills: Implementations of each skill by its name, in the order in which they are tried.
        cell: What all skill managers share.
    """

    def __init__(self, agent: str, skills: Mapping[str, Sequence[Skill]], cell: CellModules) -> None:
        self.agent = agent
        self.skills = skills
        self.primitives = cell.primitives
        self.documents = cell.documents
        self._cell = cell
        self._loader = Loader(cell.primitives, cell.config, cell.cycle.activity)

    def kind(self, module: str) -> str:
        """Returns "skill", "primitive" or "document".

        Raises:
            UnknownName: There is no such module.
        """
        if module in self.skills:
            return "skill"
        if module in self.primitives:
            return "primitive"
        if module in self.documents:
            return "document"
        known = [*self.skills, *self.primitives, *self.documents]
        raise UnknownName("module", module, known, where=f"of {self.agent}")

    def info(self, module: str) -> ModuleInfo:
        """Describes one module.

        Raises:
            UnknownName: There is no such module.
        """
        kind = self.kind(module)
        if kind == "document":
            found = self.documents[module]
            outputs = tuple(Output(name, "", "") for name in found.outputs)
            return ModuleInfo(module, kind, found.help, found.params, str(found.revision), outputs=outputs)
        if kind == "skill":
            ways = self.skills[module]
            first, labels = ways[0], tuple(skill.label for skill in ways)
            return ModuleInfo(module, "skill", first.description.help, first.description.params, first.version, labels)
        cls = self.primitives[module]
        help_ = (cls.__doc__ or "").strip().partition("\n")[0]
        return ModuleInfo(module, "primitive", help_, params_of(cls.Params), cls.version, outputs=cls.outputs)

    def run(self, module: str, arguments: Mapping[str, Any], scope: Scope, run: str = "") -> Execution[Outcome]:
        """Returns the run of a module within a scope; ticked to its end, or closed.

        A skill that another subsystem does runs as by the skill manager of that one.

        Args:
            module: Its name.
            arguments: Its parameters.
            scope: What it runs in.
            run: Id of this run; a new one where left out.

        Raises:
            UnknownName: There is no such module.
        """
        able = self._cell.who_runs(module, arguments, self)
        if able is not self:
            return able.run(module, arguments, replace(scope, agent=able.agent, modules=able), run)
        kind = self.kind(module)
        if kind == "document":
            return BehaviourRun(module, self.documents[module], arguments, scope, run).execute()
        if kind == "skill":
            return SkillRun(self.skills[module], arguments, scope, self.take, run).execute()
        loaded = self._loader.get(module, scope.context)
        if isinstance(loaded, Failure):
            return failed(loaded)
        return PrimitiveRun(loaded, arguments, scope, self.take, run).execute()

    def prepare(self, module: str, context: RunContext) -> None:
        """Loads the primitives that a module is made of, as far as its composition names them.

        Those that a primitive calls by itself are loaded when it does.
        """
        self._prepare(module, {}, context, set())

    def take(self, owner: str, devices: Mapping[str, Access], within: Claim | None) -> Claim:
        """Asks for devices, out of those of the module around it.

        Raises:
            DescriptionError: A device is to be shared whose kind has no mix rule, or the module around has not declared
                a device.
        """
        board = self._cell.context.board
        shared = [device for device, access in devices.items() if access is Access.SHARED]
        for spec in (board.devices[device] for device in shared if device in board.devices):
            if not spec.mixes():
                raise DescriptionError(f"{owner} shares {spec.id}, but kind '{spec.kind}' has no mix rule")
        claim = self._cell.claims.request(owner, devices, shared=shared, within=within)
        task = board.owner
        if within is None and task is not None:
            task.devices = claim.devices
        return claim

    def reset(self, module: str, context: RunContext) -> None:
        """Makes a primitive fit to run again after a fault; where that fails, it is loaded again for the next run.

        Raises:
            ModuleError: Its code broke.
        """
        self._loader.reset(module, context)

    def _prepare(
        self, module: str, arguments: Mapping[str, Any], context: RunContext, seen: set[tuple[str, str]]
    ) -> None:
        able = self._cell.who_runs(module, arguments, self)
        if (able.agent, module) in seen:
            return
        seen.add((able.agent, module))
        if module not in able.skills and module in able.primitives:
            able._loader.prepare(module, context)  # noqa: SLF001 - one of the same class
        bodies = [skill.nodes for skill in able.skills.get(module, ())]
        if module in able.documents:
            bodies.append((able.documents[module].behaviour,))
        for nodes in bodies:
            for call in calls_of(*nodes):
                able._prepare(call.module, call.arguments, context, seen)  # noqa: SLF001 - one of the same class
