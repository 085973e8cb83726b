"""Looks at every plug-in that is installed, and loads it to see whether it works."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from skiros_py.catalogue.fitting import fitting
from skiros_py.catalogue.loading import checked, load_catalogue
from skiros_py.config import SCENE_SUFFIXES, ontology_paths, plugin_scenes, scene_paths
from skiros_py.errors import FileError, UnknownName
from skiros_py.plugins import GROUPS, Entry, PluginFault, fault_of, installation, unambiguous
from skiros_py.world.ontology import load_installed
from skiros_py.world.scene.robots import documents_of

_WITH_FILES = ("skiros.robots", "skiros.scenes")
_LOADED_BY_USERS = ("skiros.adapters", "skiros.pages", "skiros.topics")
"""The catalogue has none of these: whatever uses one finds it by its group."""


@dataclass(frozen=True, slots=True)
class Surveyed:
    """One entry point, and whether it works.

    Attributes:
        entry: The entry point.
        faults: What is wrong with it; nothing where it works.
    """

    entry: Entry
    faults: tuple[PluginFault, ...]

    @property
    def works(self) -> bool:
        """True where nothing is wrong."""
        return not self.faults


def survey() -> tuple[tuple[Surveyed, ...], tuple[PluginFault, ...]]:
    """Loads every plug-in, without being hurt by any.

    Returns:
        All entry points by group and name; and the faults that belong to none of them.
    """
    found = installation()
    faults = [replace(fault, name=fault.name.partition("[")[0]) for fault in (*_of_code(), *_of_files())]
    for entry in found.entries:
        if entry.group not in GROUPS:
            faults.append(fault_of(entry, str(UnknownName("group of entry points", entry.group, GROUPS))))
        elif entry.group in _LOADED_BY_USERS and isinstance(one := checked(entry), PluginFault):
            faults.append(one)
    seen = tuple(Surveyed(entry, tuple(f for f in faults if _is_about(f, entry))) for entry in found.entries)
    about = {fault for one in seen for fault in one.faults}
    return seen, tuple(fault for fault in faults if fault not in about)


def _is_about(fault: PluginFault, entry: Entry) -> bool:
    return (fault.group, fault.name, fault.distribution) == (entry.group, entry.name, str(entry.distribution))


def _of_code() -> tuple[PluginFault, ...]:
    catalogue = load_catalogue()
    catalogue.load_all()
    try:
        ontology, _ = load_installed(ontology_paths())
    except FileError:
        return catalogue.faults
    return fitting(catalogue, ontology, catalogue.reasoners).faults


def _of_files() -> Iterator[PluginFault]:
    for group in _WITH_FILES:
        entries, twins = unambiguous(installation().of(group))
        yield from twins
        for entry in entries:
            yield from (found for found in documents_of(entry) if isinstance(found, PluginFault))
    for name, own in plugin_scenes().items():
        yield from (fault_of(entry, reason) for entry in own if (reason := _hidden(name, own)))


def _hidden(name: str, entries: Sequence[Entry]) -> str | None:
    """Returns why a plug-in's scene cannot be opened by name, or None."""
    if len(entries) > 1:
        return f"more than one plug-in has a scene '{name}': {' and '.join(map(str, entries))}; neither counts"
    own = (folder for folder in scene_paths() for suffix in SCENE_SUFFIXES if (folder / f"{name}{suffix}").is_file())
    folder = next(own, None)
    return f"its scene '{name}' is hidden by the one in {folder}" if folder else None
