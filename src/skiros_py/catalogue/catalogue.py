"""The contributions of plug-ins, and the modules that cannot be used: ambiguous names, calls of broken skills."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import partial
from typing import TYPE_CHECKING, Any

from skiros_py.behaviours.document_kind import DocumentKind
from skiros_py.errors import DescriptionError, DeviceError, PlanningError, SkirosError, UnknownName, UsageError
from skiros_py.interruptions import limited
from skiros_py.planning.explanation.absent import AbsentSkill
from skiros_py.planning.planners.planner import Planners
from skiros_py.planning.planners.program_planner import EVERYTHING, CommandPlanner
from skiros_py.plugins.loading import LazyPlugins
from skiros_py.plugins.plugin import Entry, Plugin, PluginFault
from skiros_py.ports.signals import SignalProvider, provider_problem
from skiros_py.skills.behaviour import Behaviour, calls_of
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoners

if TYPE_CHECKING:
    from skiros_py.planning.planners.planner import Planner
    from skiros_py.ports.cell import CellSpec
    from skiros_py.ports.driver import CellDriver


_LONGEST = 30.0
"""Wall time in which a plug-in has to make its signal providers [s]."""
_OF_PLANNERS = ("name", "supports", "solve", "close")


@dataclass(frozen=True, slots=True)
class Catalogue:
    """The contributions of plug-ins; and the faults of those that did not load.

    Attributes:
        skills: Skills by the names of their entry points.
        primitives: Primitives by name; each is loaded on first use.
        conditions: Conditions by word.
        planners: Factories of planners by name; each is loaded on first use.
        sources: Distributions ("skiros-skills 0.1.0") by kind and name ("skills/drive").
        early: Faults that were known when the catalogue was made.
        reasoners: Reasoners that worlds are opened with.
        drivers: Factories of cell drivers by name; each is loaded on first use.
        behaviours: Kinds of node by name; each is loaded on first use.
        documents: Kinds of document by name; each is loaded on first use.
        signals: Factories of the signal providers of a cell, by name.
        elsewhere: Names of skills without an implementation for the driver of this catalogue.
        fake: True if the driver is the fake one.
        absent: Skills that are installed but cannot be used.
    """

    skills: Mapping[str, Skill]
    primitives: Mapping[str, type[Primitive[Any]]]
    conditions: Mapping[str, ConditionType]
    planners: Mapping[str, Any]
    sources: Mapping[str, str]
    early: tuple[PluginFault, ...] = ()
    reasoners: Reasoners = NO_REASONERS
    drivers: Mapping[str, Any] = field(default_factory=dict)
    behaviours: Mapping[str, type[Behaviour]] = field(default_factory=dict)
    documents: Mapping[str, type[DocumentKind]] = field(default_factory=dict)
    signals: Mapping[str, Any] = field(default_factory=dict)
    elsewhere: frozenset[str] = frozenset()
    fake: bool = False
    absent: tuple[AbsentSkill, ...] = ()

    @property
    def faults(self) -> tuple[PluginFault, ...]:
        """All faults known so far, also of plug-ins that failed on first use."""
        late = (fault for lazy in self._lazy() for fault in lazy.faults)
        return tuple(dict.fromkeys((*self.early, *late)))

    def load_all(self) -> None:
        """Loads everything that is loaded on first use; :attr:`faults` then has all faults."""
        for lazy in self._lazy():
            lazy.load_all()

    def _lazy(self) -> Iterator[LazyPlugins[Any]]:
        values = (getattr(self, field.name) for field in fields(self))
        return (value for value in values if isinstance(value, LazyPlugins))

    def planner(self, name: str) -> Planner:
        """Makes a planner; close it.

        Raises:
            UnknownName: There is none of that name.
            UsageError: It cannot be loaded, or is no planner; the text gives the reason and the distribution.
            PlanningError: Its factory raises.
        """
        planner: Planner = self._made("planner", name, self.planners, PlanningError)
        missing = [attribute for attribute in _OF_PLANNERS if not hasattr(planner, attribute)]
        if missing:
            source = self._source("planner", name)
            raise UsageError(f"planner '{name}' of {source} is no Planner: it has no {', '.join(missing)}")
        return planner

    def planners_only(self) -> Catalogue:
        """Returns a catalogue with the planners only: planning needs no more."""
        sources = {name: source for name, source in self.sources.items() if name.startswith("planners/")}
        return Catalogue({}, {}, {}, self.planners, sources)

    def choice_of_planners(self, wanted: str | None = None, command: str | None = None) -> Planners:
        """Returns the planners to choose from, by their supported requirements; close it.

        Args:
            wanted: Name of the only planner to use; None to choose by requirements.
            command: Command line of a planner, instead of a name.

        Raises:
            UnknownName: There is none of that name.
            UsageError: The requested one cannot be loaded; the text gives the reason and the distribution.
        """
        if command is not None:
            return Planners.only(CommandPlanner("command", command, supports=EVERYTHING))
        if wanted is not None:
            self._factory("planner", wanted, self.planners)
        names = self.planners.names if isinstance(self.planners, LazyPlugins) else tuple(self.planners)
        return Planners(names, self.planner, wanted)

    def driver(self, name: str, *arguments: Any, **options: Any) -> CellDriver:
        """Makes a cell driver; close it.

        Args:
            name: Its name.
            *arguments: Arguments of its factory: the cell.
            **options: Further arguments: the seed.

        Raises:
            UnknownName: There is none of that name.
            UsageError: It cannot be loaded; the text gives the reason and the distribution.
            DeviceError: Its factory raises.
        """
        driver: CellDriver = self._made("driver", name, self.drivers, DeviceError, *arguments, **options)
        return driver

    def chosen_skills(self, names: Sequence[str]) -> list[Skill]:
        """Returns the skills of some names, in order; all of them if no name is given.

        Raises:
            UnknownName: There is none of a name.
            UsageError: One has no implementation for the driver.
        """
        skills = [skill for _, skill in sorted(self.skills.items())]
        known = {skill.description.name for skill in skills}
        for name in names:
            if name in self.elsewhere:
                raise UsageError(self.why_elsewhere(name))
            if name not in known:
                raise UnknownName("skill", name, known)
        return [skill for skill in skills if not names or skill.description.name in names]

    def why_elsewhere(self, *skills: str) -> str:
        """Returns a message that skills have no implementation for the driver in use."""
        are, have = ("is", "has") if len(skills) == 1 else ("are", "have")
        lacks = "no implementation for driver fake" if self.fake else "implementations for driver fake only"
        return f"{', '.join(skills)} {are} there, but {have} {lacks}"

    def signal_providers(self, cell: CellSpec) -> tuple[list[tuple[SignalProvider, str]], tuple[PluginFault, ...]]:
        """Makes the signal providers of a cell.

        Returns:
            Each with its distribution; and the faults of plug-ins that raise, hang or make something else.
        """
        made: list[tuple[SignalProvider, str]] = []
        faults: list[PluginFault] = []
        for name, factory in self.signals.items():
            source = self._source("signal", name)
            what = f"signals '{name}' of {source}"
            try:
                providers = limited(partial(str, what), _LONGEST, partial(_providers, factory, cell))
            except Exception as error:  # noqa: BLE001 - a plug-in's code: the cell does without its signals
                reason = str(error) if isinstance(error, SkirosError) else f"{type(error).__name__}: {error}"
                trace = "".join(traceback.format_exception(error))
                faults.append(PluginFault("skiros.signals", name, source, f"{what}: {reason}", trace))
            else:
                made += [(provider, source) for provider in providers]
        return made, tuple(faults)

    def _made(
        self, kind: str, name: str, found: Mapping[str, Any], fault: type[SkirosError], *arguments: Any, **options: Any
    ) -> Any:
        make = self._factory(kind, name, found)
        try:
            return make(*arguments, **options)
        except SkirosError:
            raise
        except Exception as error:
            breaks = f"{kind} '{name}' of {self._source(kind, name)} breaks"
            raise fault(f"{breaks}: {type(error).__name__}: {error}") from error

    def _source(self, kind: str, name: str) -> str:
        return self.sources.get(f"{kind}s/{name}", "this catalogue")

    def _factory(self, kind: str, name: str, found: Mapping[str, Any]) -> Any:
        if name in found:
            return found[name]
        reason = found.why_not(name) if isinstance(found, LazyPlugins) else None
        early = (str(fault) for fault in self.early if (fault.group, fault.name) == (f"skiros.{kind}s", name))
        if (reason := reason or next(early, None)) is None:
            raise UnknownName(kind, name, found)
        raise UsageError(f"{kind} '{name}' cannot be used: {reason} (skiros plugins {name} shows it in full)")


def _providers(factory: Callable[[CellSpec], Iterable[SignalProvider]], cell: CellSpec) -> list[SignalProvider]:
    """Makes providers.

    Raises:
        DescriptionError: One of them is none.
    """
    providers = list(factory(cell))
    if wrong := next((problem for one in providers if (problem := provider_problem(one))), None):
        raise DescriptionError(wrong)
    return providers


@dataclass(frozen=True, slots=True)
class Named:
    """An object that an entry point names.

    Attributes:
        plugin: The entry point, loaded.
        key: Name in the catalogue: that of the entry point, with a number if it names several.
        value: The object.
    """

    plugin: Plugin
    key: str
    value: Any

    @property
    def origin(self) -> str:
        """Its key and distribution, for people."""
        return f"{self.key} of {self.plugin.distribution}"


def clashes_of_modules(skills: Sequence[Named], primitives: Collection[Entry]) -> tuple[dict[str, str], dict[str, str]]:
    """Finds skills and primitives with ambiguous names, which compositions cannot use.

    Several implementations of one description are no clash. Different descriptions of one name are, and so are two
    implementations of one label for one driver, and a skill and a primitive of one name, for compositions call both.

    Returns:
        The reasons by the keys of the skills, and by the names of the primitives.
    """
    by_name = _by(skills, lambda skill: skill.description.name)
    both = [entry for entry in primitives if entry.name in by_name]
    reasons = {entry.name: _both(entry, by_name[entry.name]) for entry in both}
    of_skills = {one.key: reason for name, reason in reasons.items() for one in by_name[name]}
    entries: dict[str, Entry] = {}
    for entry in primitives:
        if (other := entries.setdefault(entry.name, entry)) != entry:
            reasons[entry.name] = f"'{entry.name}' is the name of two primitives, {other} and {entry}: rename one"
    for name, own in by_name.items():
        if name not in reasons:
            of_skills |= dict(_among_skills(name, own))
    return of_skills, reasons


def clashes_of_conditions(conditions: Sequence[Named]) -> dict[str, str]:
    """Returns the reasons, by key, why conditions cannot be used: their word is ambiguous."""
    words = _by(conditions, lambda condition: condition.name)
    return {
        one.key: _twice("condition", word, own)
        for word, own in words.items()
        if any(other.value != own[0].value for other in own)
        for one in own
    }


def _both(primitive: Entry, skills: Sequence[Named]) -> str:
    origins = ", ".join(skill.origin for skill in skills)
    twice = f"'{primitive.name}' is the name of a skill ({origins}) and of a primitive ({primitive})"
    return f"{twice}: neither counts, rename one of them"


def _among_skills(name: str, skills: Sequence[Named]) -> Iterator[tuple[str, str]]:
    if any(one.value.description != skills[0].value.description for one in skills):
        yield from ((one.key, _twice("description of skill", name, skills)) for one in skills)
        return
    labelled = [one for one in skills if one.value.label]  # without a label the entry point's name tells them apart
    for (label, _), own in _by(labelled, lambda skill: (skill.label, skill.driver)).items():
        if len(own) > 1:
            yield from ((one.key, _twice(f"implementation of '{name}' called", label, own)) for one in own)


def _by(things: Sequence[Named], key: Callable[[Any], Hashable]) -> Mapping[Any, list[Named]]:
    groups: dict[Hashable, list[Named]] = {}
    for thing in things:
        groups.setdefault(key(thing.value), []).append(thing)
    return groups


def _twice(kind: str, name: str, things: Sequence[Named]) -> str:
    origins = " and ".join(thing.origin for thing in things)
    return f"there is more than one {kind} '{name}': {origins}; none of them counts, rename one"


# ---------------------------------------------------------------- who calls whom


def called_by(skill: Skill) -> tuple[str, ...]:
    """Returns the names of the modules that a skill calls, in alphabetical order."""
    return tuple(sorted({call.module for call in calls_of(*skill.nodes)}))


def callers_of_broken(skills: Mapping[str, Skill], broken: Mapping[str, str]) -> dict[str, str]:
    """Finds the skills that call, however indirectly, one of which no implementation can be used.

    Args:
        skills: Implementations by their keys.
        broken: The reasons, by key, why some cannot be used, of these or of others.

    Returns:
        The reasons, by key, why further ones cannot.
    """
    found: dict[str, str] = {}
    while True:
        known = {**broken, **found}
        left = {skill.description.name for key, skill in skills.items() if key not in known}
        reasons = {skills[key].description.name: reason for key, reason in known.items() if key in skills}
        gone = {name: reason for name, reason in reasons.items() if name not in left}
        more: dict[str, str] = {}
        for key, skill in skills.items():
            name = next((name for name in called_by(skill) if name in gone), None)
            if name is not None and key not in known:
                more[key] = f"it calls '{name}': {gone[name]}"
        if not more:
            return found
        found |= more
