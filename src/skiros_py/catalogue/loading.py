"""Loads plug-ins: the requirements of each entry-point group, and the skills that can be used with an ontology."""

from __future__ import annotations

import inspect
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, is_dataclass, replace
from functools import partial
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from skiros_py.authoring import SkillBase
from skiros_py.behaviours.document_kind import DocumentKind
from skiros_py.catalogue.catalogue import (
    Catalogue,
    Named,
    called_by,
    callers_of_broken,
    clashes_of_conditions,
    clashes_of_modules,
)
from skiros_py.catalogue.naming import OfferedNames, kind_offered
from skiros_py.config import ontology_paths
from skiros_py.errors import FileError, GoalSyntaxError, PlanningError, SkirosError, UnknownName
from skiros_py.interruptions import by_user
from skiros_py.planning.domain.actions import actions_of
from skiros_py.planning.explanation.absent import AbsentSkill
from skiros_py.plugins.installation import GROUPS, installation
from skiros_py.plugins.loading import LazyPlugins, fault_of, load, load_plugins
from skiros_py.plugins.plugin import Entry, Plugin, PluginFault, by_cause
from skiros_py.ports.adapters import Adapter, adapter_problem
from skiros_py.ports.device import DeviceSpec
from skiros_py.ports.device_kinds import device_problem, load_device_kinds
from skiros_py.ports.kinematics import RobotModel
from skiros_py.skills.behaviour import Behaviour
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.lint.checking import problems_of
from skiros_py.skills.parameters import params_of
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.tasks.goals.forms import Word, read
from skiros_py.world.ontology import Ontology, load_installed
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoner, Reasoners, load_reasoners
from skiros_py.world.scene.files import documents_of
from skiros_py.world.vocabulary import REFINED_SKILLS


@dataclass(frozen=True, slots=True)
class Kind:
    """One group of entry points.

    Attributes:
        group: The group ("skiros.skills").
        names: The objects that its entry points name, for people.
        is_one: Returns whether an object is of that kind.
        finer: Returns a further problem of such an object, or None.
    """

    group: str
    names: str
    is_one: Callable[[Any], bool]
    finer: Callable[[Plugin], str | None] = lambda _: None

    def problem(self, plugin: Plugin) -> str | None:
        """Returns why a plug-in cannot be used, or None."""
        if not self.is_one(plugin.value):
            kind = self.group.partition(".")[2]
            return f"it is a {type(plugin.value).__name__}, nothing for {kind}: name {self.names}"
        return self.finer(plugin)


def skills_of(plugin: Plugin) -> Mapping[str, Skill]:
    """Returns the skills that an entry point names: one under its name, several as ``name[1]``, ``name[2]``, ….

    A class makes one under its name, and ``name[fake]``.
    """
    if isinstance(plugin.value, Skill):
        return {plugin.name: plugin.value}
    if _is_skill_class(plugin.value):
        return {plugin.name: plugin.value.skill, f"{plugin.name}[fake]": plugin.value.fake}
    return {f"{plugin.name}[{number}]": skill for number, skill in enumerate(plugin.value, start=1)}


def _is_skill_class(value: Any) -> bool:
    return isinstance(value, type) and issubclass(value, SkillBase) and "skill" in vars(value)


def _is_skill(value: Any) -> bool:
    if _is_skill_class(value):
        return True
    if isinstance(value, Sequence) and not isinstance(value, str) and value:
        return all(isinstance(one, Skill) for one in value)
    return isinstance(value, Skill)


def _wrong_skill(plugin: Plugin) -> str | None:
    for skill in skills_of(plugin).values():
        description: Any = skill.description  # nothing keeps a dataclass from being made with something else
        if not isinstance(description, SkillDescription):
            return f"its description is a {type(description).__name__}, not a SkillDescription"
        texts = {"name": description.name, "label": skill.label, "driver": skill.driver or ""}
        for what, text in texts.items():
            if (wrong := _no_text(text)) is not None:
                return f"its {what} is {wrong}, not a text"
    return None


def _wrong_condition(plugin: Plugin) -> str | None:
    name = plugin.value.name
    if (wrong := _no_text(name)) is not None:
        return f"its name is {wrong}, not a word"
    try:
        is_word = isinstance(read(f"{name}(x)"), Word)
    except GoalSyntaxError:
        is_word = False
    return None if is_word else f"no goal can say its name '{name}': use letters and digits, such as LocationEmpty"


def _no_text(value: Any) -> str | None:
    """Returns the representation of a value that is not a text; None for a text."""
    return None if isinstance(value, str) else repr(value)


def _wrong_primitive(plugin: Plugin) -> str | None:
    class_ = plugin.value
    if wrong := _wrong_class(plugin, "name", "compositions"):
        return wrong
    if not is_dataclass(getattr(class_, "Params", None)):
        return "it has no Params: a frozen dataclass, empty where it takes nothing"
    try:
        params_of(class_.Params)
    except SkirosError as error:
        return str(error)
    return None


def _wrong_class(plugin: Plugin, attribute: str, users: str) -> str | None:
    class_ = plugin.value
    own = getattr(class_, attribute, None)
    if own != plugin.own_name:
        called = f"its {attribute} is {own!r}" if own else f"it has no {attribute}"
        return f"{called}: {users} find it as '{plugin.own_name}', so both must be the same"
    missing = sorted(class_.__abstractmethods__) if inspect.isabstract(class_) else []
    return f"it does not define {', '.join(missing)}" if missing else None


def _instance_of(*types: type) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, types)


def _subclass_of(base: type) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, type) and issubclass(value, base)


def _wrong_driver(plugin: Plugin) -> str | None:
    """Returns which methods a class of cell drivers lacks; what another callable makes shows only when it is called."""
    wanted = ("read", "exchange", "halt", "release", "capture", "close")
    lacks = [name for name in wanted if not hasattr(plugin.value, name)] if isinstance(plugin.value, type) else []
    return f"it is no CellDriver: it has no {', no '.join(lacks)}" if lacks else None


_of_kind = partial(_wrong_class, attribute="kind", users="documents")
_is_files = _instance_of(Path, Traversable)
_is_robot = _instance_of(RobotModel, Path, Traversable)

KINDS: Mapping[str, Kind] = {
    kind.group: kind
    for kind in (
        Kind("skiros.skills", "a Skill, or a sequence of them, or a SkillBase class", _is_skill, _wrong_skill),
        Kind("skiros.primitives", "a subclass of Primitive", _subclass_of(Primitive), _wrong_primitive),
        Kind("skiros.behaviours", "a subclass of Behaviour", _subclass_of(Behaviour), _of_kind),
        Kind("skiros.documents", "a subclass of DocumentKind", _subclass_of(DocumentKind), _of_kind),
        Kind("skiros.conditions", "a ConditionType", _instance_of(ConditionType), _wrong_condition),
        Kind("skiros.reasoners", "a subclass of Reasoner", _subclass_of(Reasoner)),
        Kind("skiros.planners", "what makes a Planner when it is called", callable),
        Kind("skiros.devices", "a subclass of DeviceSpec", _subclass_of(DeviceSpec), device_problem),
        Kind("skiros.adapters", "an Adapter", _instance_of(Adapter), adapter_problem),
        Kind("skiros.drivers", "what makes a CellDriver when it is called", callable, _wrong_driver),
        Kind("skiros.signals", "a function of the cell that returns signal providers", callable),
        Kind("skiros.engines", "what makes a simulation Engine when it is called", callable),
        Kind("skiros.ontologies", "a package with ontology files, or a Path", _is_files),
        Kind("skiros.robots", "a RobotModel, a package with Turtle files, or a Path", _is_robot),
        Kind("skiros.scenes", "a package with scene files, or a Path", _is_files),
        Kind("skiros.pages", "the Path of a folder of built web pages", _instance_of(Path)),
        Kind("skiros.topics", "a function that takes a Recorder", callable),
    )
}
"""By group."""


def load_catalogue() -> Catalogue:
    """Finds the skills, primitives, behaviours, conditions, planners and drivers of all distributions.

    Skills and conditions are loaded, because planning needs their descriptions; everything else is loaded on first use.
    Worlds are opened with the reasoners; the faults of the plug-ins of
    ``skiros.devices``, ``skiros.reasoners`` and ``skiros.ontologies`` are among the faults.
    """
    found = _Found()
    lazy: dict[str, Any] = {kind: LazyPlugins(found.entries(kind), _problem) for kind in _LAZY}
    kinds: dict[str, Any] = {kind: LazyPlugins(found.entries(kind), _problem, kind_offered) for kind in _KINDS}
    skills, conditions = found.skills(), found.conditions()
    primitives = [*found.entries("primitives"), *found.primitives_of(skills)]
    names = OfferedNames.of(skills, primitives, conditions)
    primitives = [names.entry(entry) for entry in primitives]
    skills, conditions = list(map(names.named, skills)), list(map(names.named, conditions))
    of_skills, of_primitives = clashes_of_modules(skills, primitives)
    ontology, misfits = _installed()
    reasoners, unusable = load_reasoners(ontology)
    return Catalogue(
        skills=found.usable(skills, of_skills),
        primitives=LazyPlugins(found.alone(primitives, of_primitives), _problem, names.primitive),
        conditions=found.usable(conditions, clashes_of_conditions(conditions)),
        sources=found.sources,
        early=(*installation().faults, *found.faults, *unusable, *load_device_kinds()[1], *misfits),
        reasoners=reasoners,
        **lazy,
        **kinds,
    )


_LAZY = ("planners", "drivers", "signals")
_KINDS = ("behaviours", "documents")


class _Found:
    """The plug-ins found, and the faults of the others.

    Attributes:
        faults: The faults.
        sources: The distribution of each, by kind and name.
    """

    def __init__(self) -> None:
        self.faults: list[PluginFault] = []
        self.sources: dict[str, str] = {}

    def entries(self, kind: str) -> Sequence[Entry]:
        """Returns the entry points of a group."""
        entries = installation().of(f"skiros.{kind}")
        self.sources |= {f"{kind}/{entry.name}": str(entry.distribution) for entry in entries}
        return entries

    def skills(self) -> list[Named]:
        """Loads the skills."""
        return [Named(p, key, skill) for p in self._plugins("skills") for key, skill in skills_of(p).items()]

    def primitives_of(self, skills: Iterable[Named]) -> Iterator[Entry]:
        """Yields entry points of the primitives that come with skills."""
        distributions = {str(distribution): distribution for distribution in installation().distributions}
        for own, class_ in dict.fromkeys((s.plugin.distribution, one) for s in skills for one in s.value.primitives):
            self.sources[f"primitives/{class_.name}"] = own
            value = f"{class_.__module__}:{class_.__qualname__}"
            yield Entry("skiros.primitives", class_.name, value, distributions[own])

    def conditions(self) -> list[Named]:
        """Loads the conditions."""
        return [Named(plugin, plugin.name, plugin.value) for plugin in self._plugins("conditions")]

    def _plugins(self, kind: str) -> tuple[Plugin, ...]:
        plugins, faults = load_plugins(f"skiros.{kind}", _problem)
        self.faults += faults
        return plugins

    def usable(self, things: Iterable[Named], clashes: Mapping[str, str]) -> dict[str, Any]:
        """Returns the objects by key, without those with ambiguous names."""
        good = {}
        for thing in things:
            plugin = thing.plugin
            if thing.key in clashes:
                self.faults.append(plugin.fault(clashes[thing.key]))
            else:
                good[thing.key] = thing.value
                self.sources[f"{plugin.group.partition('.')[2]}/{thing.key}"] = plugin.distribution
        return good

    def alone(self, entries: Sequence[Entry], clashes: Mapping[str, str]) -> list[Entry]:
        """Returns the entry points without those with ambiguous names."""
        self.faults += [fault_of(entry, clashes[entry.name]) for entry in entries if entry.name in clashes]
        return [entry for entry in entries if entry.name not in clashes]


def _problem(plugin: Plugin) -> str | None:
    return KINDS[plugin.group].problem(plugin)


def _installed() -> tuple[Ontology | None, tuple[PluginFault, ...]]:
    try:
        return load_installed(ontology_paths())
    except FileError:
        return None, ()  # not the fault of a plug-in; reported when a scene is opened


def fitting(
    catalogue: Catalogue, ontology: Ontology, reasoners: Reasoners = NO_REASONERS, *, fake: bool | None = None
) -> Catalogue:
    """Leaves out skills that cannot be used with an ontology; they are reported.

    A skill must use words that the ontology declares, relations that a reasoner computes and modules that exist and can
    be used themselves, and it must be possible to plan with it.

    Args:
        catalogue: The catalogue.
        ontology: The ontology.
        reasoners: The reasoners for computed relations.
        fake: True if only skills for fakes will be used, False if only the others: unused ones are left out unchecked,
            and the modules that they call are not loaded. None to check all.
    """
    wanted = {n: s for n, s in catalogue.skills.items() if fake is None or fake == _is_fake(s)}
    sides = {side: {n: s for n, s in wanted.items() if _is_fake(s) is side} for side in (True, False)}
    faults: dict[str, PluginFault] = {}
    for name, skill in wanted.items():
        try:
            if problems := _problems(catalogue, skill, sides[_is_fake(skill)].values(), ontology, reasoners):
                faults[name] = _fault(catalogue, name, "; ".join(problems))
            else:
                actions_of(skill.description.under([skill.when]), ontology)
        except PlanningError as error:
            faults[name] = _fault(catalogue, name, str(error))
        except BaseException as error:
            if by_user(error):
                raise
            faults[name] = _fault(catalogue, name, f"{type(error).__name__}: {error}", traceback.format_exc())
    reasons = {name: fault.reason for name, fault in faults.items()}
    for side in sides.values():  # those for fakes and the others never meet in one run, so they cannot call each other
        faults |= {name: _fault(catalogue, name, reason) for name, reason in callers_of_broken(side, reasons).items()}
    good = {name: skill for name, skill in wanted.items() if name not in faults}
    early = (*catalogue.early, *(faults[n] for n in wanted if n in faults))
    elsewhere = _names(catalogue.skills.values()) - _names(wanted.values())
    absent = (
        *(AbsentSkill.of(wanted[n].description, str(fault)) for n, fault in faults.items() if n in wanted),
        *(AbsentSkill(str(fault)) for fault in by_cause(f for f in catalogue.early if f.group == "skiros.skills")),
    )
    return replace(catalogue, skills=good, early=early, elsewhere=elsewhere, fake=bool(fake), absent=absent)


def _names(skills: Iterable[Skill]) -> frozenset[str]:
    return frozenset(skill.description.name for skill in skills)


def _is_fake(skill: Skill) -> bool:
    return skill.driver == "fake"


def _problems(
    catalogue: Catalogue, skill: Skill, beside: Iterable[Skill], ontology: Ontology, reasoners: Reasoners
) -> tuple[str, ...]:
    broken = tuple(_broken_calls(catalogue, skill))
    broken = broken or problems_of(skill, ontology, catalogue.primitives, reasoners, tuple(beside))
    return broken or tuple(_not_refined(skill.description, ontology))


def _not_refined(description: SkillDescription, ontology: Ontology) -> Iterator[str]:
    """Yields why agents would have the skill that this one refines, too, as it is."""
    class_, general = description.agent_class, description.refines
    if general and general not in str(ontology.class_value(class_, REFINED_SKILLS) or "").split():
        yield f"it refines '{general}', so the ontology must say of {class_}: sk:refinedSkills \"{general}\""


def _fault(catalogue: Catalogue, name: str, reason: str, trace: str = "") -> PluginFault:
    source, (origin, line) = catalogue.sources.get(f"skills/{name}", "this catalogue"), catalogue.skills[name].source
    return PluginFault("skiros.skills", name, source, reason, trace, origin, line=line)


def _broken_calls(catalogue: Catalogue, skill: Skill) -> Iterator[str]:
    """Yields the faults of modules that a skill calls and that exist, but cannot be used."""
    primitives = catalogue.primitives
    unloaded = {fault.name: fault for fault in catalogue.early if fault.group == "skiros.skills"}
    there = {other.description.name for other in catalogue.skills.values()}
    for name in called_by(skill):
        reason = primitives.why_not(name) if isinstance(primitives, LazyPlugins) else None
        if reason is not None:
            yield f"it calls '{name}': {reason}"
        elif name in unloaded and name not in there and name not in primitives:
            yield f"it calls '{name}': {unloaded[name]}"


_WITH_FILES = ("skiros.robots", "skiros.scenes")
_LOADED_BY_USERS = ("skiros.adapters", "skiros.pages", "skiros.topics")
"""Groups outside of the catalogue: their users find them by group."""


@dataclass(frozen=True, slots=True)
class Surveyed:
    """One entry point, with its faults.

    Attributes:
        entry: The entry point.
        faults: Its faults; empty if it works.
    """

    entry: Entry
    faults: tuple[PluginFault, ...]

    @property
    def works(self) -> bool:
        """True if it has no faults."""
        return not self.faults


def survey() -> tuple[tuple[Surveyed, ...], tuple[PluginFault, ...]]:
    """Loads every plug-in; faults are contained.

    Returns:
        All entry points by group and name; and the faults of none of them.
    """
    found = installation()
    faults = [replace(fault, name=fault.name.partition("[")[0]) for fault in (*_of_code(), *_of_files())]
    for entry in found.entries:
        if entry.group not in GROUPS:
            faults.append(fault_of(entry, str(UnknownName("group of entry points", entry.group, GROUPS))))
        elif entry.group in _LOADED_BY_USERS and isinstance(one := load(entry, _problem), PluginFault):
            faults.append(one)
    seen = tuple(Surveyed(entry, tuple(f for f in faults if _is_about(f, entry))) for entry in found.entries)
    about = {fault for one in seen for fault in one.faults}
    return seen, tuple(fault for fault in faults if fault not in about)


def _is_about(fault: PluginFault, entry: Entry) -> bool:
    same = (fault.group, fault.distribution) == (entry.group, str(entry.distribution))
    return same and fault.name in (entry.name, entry.own_name)


def _of_code() -> tuple[PluginFault, ...]:
    catalogue = load_catalogue()
    catalogue.load_all()
    try:
        ontology, _ = load_installed(ontology_paths())
    except FileError:
        return catalogue.faults
    return fitting(catalogue, ontology, catalogue.reasoners).faults


def _of_files() -> Iterator[PluginFault]:
    for entry in (entry for group in _WITH_FILES for entry in installation().of(group)):
        yield from (found for found in documents_of(entry) if isinstance(found, PluginFault))
