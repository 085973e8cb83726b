"""Loads what is installed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from skiros_py.catalogue.catalogue import Catalogue
from skiros_py.catalogue.clashes import Named, clashes_of_conditions, clashes_of_modules
from skiros_py.catalogue.kinds import KINDS, skills_of
from skiros_py.config import ontology_paths
from skiros_py.errors import FileError
from skiros_py.plugins import (
    Entry,
    LazyPlugins,
    Plugin,
    PluginFault,
    examined,
    fault_of,
    installation,
    load,
    unambiguous,
)
from skiros_py.ports.kinds import load_device_kinds
from skiros_py.world.ontology import Ontology, load_installed
from skiros_py.world.reasoners.plugins import load_reasoners


def load_catalogue() -> Catalogue:
    """Finds the skills, primitives, behaviours, conditions, planners and drivers that distributions bring.

    Skills and conditions are loaded, because planning needs their descriptions; everything else is loaded when it is
    first asked for. The reasoners are those that worlds are opened with; the faults of the plug-ins of
    ``skiros.devices``, ``skiros.reasoners`` and ``skiros.ontologies`` are among the faults.
    """
    found = _Found()
    lazy: dict[str, Any] = {kind: _lazy(found.entries(kind)) for kind in _LAZY}
    primitives = found.entries("primitives")
    skills, conditions = found.skills(), found.conditions()
    of_skills, of_primitives = clashes_of_modules(skills, primitives)
    ontology, misfits = _installed()
    reasoners, unusable = load_reasoners(ontology)
    return Catalogue(
        skills=found.usable(skills, of_skills),
        primitives=_lazy(found.alone(primitives, of_primitives)),
        conditions=found.usable(conditions, clashes_of_conditions(conditions)),
        sources=found.sources,
        early=(*installation().faults, *found.faults, *unusable, *load_device_kinds()[1], *misfits),
        reasoners=reasoners,
        **lazy,
    )


_LAZY = ("planners", "drivers", "signals", "behaviours", "documents")


class _Found:
    """What was found, and what is wrong with the rest.

    Attributes:
        faults: What cannot be used.
        sources: Where each thing is from, by kind and name.
    """

    def __init__(self) -> None:
        self.faults: list[PluginFault] = []
        self.sources: dict[str, str] = {}

    def entries(self, kind: str) -> tuple[Entry, ...]:
        """Returns the entry points of a group whose names are theirs alone."""
        entries, twins = unambiguous(installation().of(f"skiros.{kind}"))
        self.faults += twins
        self.sources |= {f"{kind}/{entry.name}": str(entry.distribution) for entry in entries}
        return entries

    def skills(self) -> list[Named]:
        """Loads the skills."""
        return [Named(p, key, skill) for p in self._plugins("skills") for key, skill in skills_of(p).items()]

    def conditions(self) -> list[Named]:
        """Loads the conditions."""
        return [Named(plugin, plugin.name, plugin.value) for plugin in self._plugins("conditions")]

    def _plugins(self, kind: str) -> list[Plugin]:
        loaded = [checked(entry) for entry in self.entries(kind)]
        self.faults += [one for one in loaded if isinstance(one, PluginFault)]
        return [one for one in loaded if isinstance(one, Plugin)]

    def usable(self, things: Iterable[Named], clashes: Mapping[str, str]) -> dict[str, Any]:
        """Returns the things by key, without those that clash."""
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
        """Returns the entry points without those that clash."""
        self.faults += [fault_of(entry, clashes[entry.name]) for entry in entries if entry.name in clashes]
        return [entry for entry in entries if entry.name not in clashes]


def _lazy(entries: Iterable[Entry]) -> LazyPlugins[Any]:
    return LazyPlugins(entries, _problem)


def _problem(plugin: Plugin) -> str | None:
    return KINDS[plugin.group].problem(plugin)


def checked(entry: Entry) -> Plugin | PluginFault:
    """Loads an entry point and looks whether it names what its group wants."""
    plugin = load(entry)
    return plugin if isinstance(plugin, PluginFault) else examined(plugin, _problem)


def _installed() -> tuple[Ontology | None, tuple[PluginFault, ...]]:
    try:
        return load_installed(ontology_paths())
    except FileError:
        return None, ()  # no plug-in's fault, and reported when a scene is opened
