"""Plug-ins: entry points, loaded plug-ins, and their faults."""

from __future__ import annotations

import re
import sysconfig
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec
from pathlib import Path
from typing import Any


def locate(module: str) -> ModuleSpec | None:
    """Returns the import specification of a module, or None if there is none.

    Unlike ``importlib.util.find_spec`` it does not import the packages around it.
    """
    top, *inner = module.split(".")
    try:
        spec = find_spec(top)
        for part in inner:
            if spec is None or spec.submodule_search_locations is None:
                return None
            # Under its full name, a folder without code is found only once the package around it is imported.
            spec = PathFinder.find_spec(part, list(spec.submodule_search_locations))
    except (ImportError, ValueError, AttributeError):  # find_spec raises for what was imported half
        return None
    return spec


def origin_of(module: str) -> str:
    """Returns the file of a module, or the folder of a package without code; empty if there is none."""
    spec = locate(module) if module else None
    if spec is None:
        return ""
    if spec.origin and Path(spec.origin).exists():
        return spec.origin
    return next(iter(spec.submodule_search_locations or ()), "")


# ---------------------------------------------------------------- stacks


_FRAME = re.compile(r'File "([^"<]+)", line (\d+)(?:, in (\S+))?')
_PLATFORM = Path(__file__).parents[1]
_STANDARD = Path(sysconfig.get_path("stdlib"))
_CALLERS = {"importlib", "click"}
"""Libraries that call the platform's code and authors' code."""


def authors_line(stack: str) -> tuple[Path, int, str] | None:
    """Returns file, line and function of the innermost frame in an author's code; None if there is none."""
    frames = [(Path(file), int(line), function) for file, line, function in _FRAME.findall(stack)]
    own = [frame for frame in frames if not _is_foreign(frame[0])]
    return own[-1] if own else None


def _is_foreign(file: Path) -> bool:
    is_standard = _STANDARD in file.parents and "site-packages" not in file.parts
    return is_standard or _PLATFORM in file.parents or not _CALLERS.isdisjoint(file.parts)


def canonical(name: str) -> str:
    """Returns the normalised name of a distribution, for comparisons."""
    return re.sub(r"[-_.]+", "-", name).lower()


def qualified(name: str, distribution: str) -> str:
    """Returns the name under which something is offered whose own name another distribution has too ("lab.pick").

    Args:
        name: Its own name.
        distribution: Its distribution, with or without version ("lab 0.3").
    """
    return f"{canonical(distribution.partition(' ')[0])}.{name}"


_REFERENCE = re.compile(r"\s*([\w.]+)\s*(?::\s*([\w.]+)\s*)?(?:\[.*\]\s*)?")


@dataclass(frozen=True, slots=True)
class Distribution:
    """An installed distribution.

    Attributes:
        name: Its name ("skiros-skills").
        version: Its version; empty if its metadata are missing.
        requires: Its requirements ("skiros-py>=0.1,<0.2").
        folder: Folder of its metadata.
    """

    name: str
    version: str
    requires: tuple[str, ...] = ()
    folder: str = ""

    def __str__(self) -> str:
        return f"{self.name} {self.version}" if self.version else f"{self.name} (no version)"


@dataclass(frozen=True, slots=True)
class Entry:
    """An entry point, not loaded.

    Attributes:
        group: Entry-point group ("skiros.skills").
        name: Name under which it is offered: that in the metadata, qualified by its distribution where it clashes.
        value: Its object reference ("skiros_skills.drive:DRIVE").
        distribution: Its distribution.
        declared: Its name in the metadata, where it is offered under another one.
    """

    group: str
    name: str
    value: str
    distribution: Distribution
    declared: str = ""

    @property
    def own_name(self) -> str:
        """Its name in the metadata of its distribution."""
        return self.declared or self.name

    def offered(self, name: str) -> Entry:
        """Returns it under the name that it is offered under."""
        return replace(self, name=name, declared=self.own_name)

    @property
    def is_well_formed(self) -> bool:
        """True if it names a module or an object in one."""
        return _REFERENCE.fullmatch(self.value) is not None

    @property
    def module(self) -> str:
        """The module that it names; empty if it is not well-formed."""
        match = _REFERENCE.fullmatch(self.value)
        return match[1] if match else ""

    @property
    def attribute(self) -> str:
        """The object that it names in the module; empty for the module itself."""
        match = _REFERENCE.fullmatch(self.value)
        return (match[2] or "") if match else ""

    def __str__(self) -> str:
        return f"{self.distribution} ({self.value})"


@dataclass(frozen=True, slots=True)
class Plugin:
    """One loaded entry point.

    Attributes:
        group: Entry-point group ("skiros.skills").
        name: Name under which it is offered.
        distribution: Its distribution, with version ("skiros-skills 0.1.0").
        value: The object it names.
        module: The module it was found in.
        declared: Its name in the metadata, where it is offered under another one.
    """

    group: str
    name: str
    distribution: str
    value: Any
    module: str = ""
    declared: str = ""

    @property
    def own_name(self) -> str:
        """Its name in the metadata of its distribution."""
        return self.declared or self.name

    @property
    def is_builtin(self) -> bool:
        """True if it belongs to the platform itself."""
        return self.distribution.startswith("skiros-py ")

    def fault(self, reason: str, traceback: str = "") -> PluginFault:
        """Makes a fault with the reason why it cannot be used."""
        origin = origin_of(self.module)
        return PluginFault(self.group, self.name, self.distribution, reason, traceback, origin)


@dataclass(frozen=True, slots=True)
class PluginFault:
    """An entry point that could not be loaded or used, with the traceback for its author.

    Attributes:
        group: Entry-point group.
        name: Name under which it would be offered.
        distribution: Its distribution, with version.
        reason: Why.
        traceback: The stack of the error; empty if none was raised, or the reason and the line say all.
        origin: File in which the fault is, or of the module it names; empty if it has none.
        unknown: Kind of the name that it uses and that does not exist ("parameter"); empty for other faults.
        line: Line of that file; 0 where it is not known.
    """

    group: str
    name: str
    distribution: str
    reason: str
    traceback: str
    origin: str = ""
    unknown: str = ""
    line: int = 0

    @property
    def reason_and_place(self) -> str:
        """The reason, and file and line if they are known."""
        return f"{self.reason} ({self.origin}:{self.line})" if self.line else self.reason

    def __str__(self) -> str:
        return f"plug-in {self.name} of {self.distribution} did not load: {self.reason_and_place}"


def by_cause(faults: Iterable[PluginFault]) -> list[PluginFault]:
    """Returns one fault for each reason in a distribution; its reason names the other plug-ins that fail by it.

    One import that fails breaks every plug-in whose module needs it.
    """
    causes: dict[tuple[str, str], list[PluginFault]] = {}
    for fault in faults:
        causes.setdefault((fault.distribution, fault.reason), []).append(fault)
    return [first if not others else _and_others(first, others) for first, *others in causes.values()]


def _and_others(fault: PluginFault, others: Sequence[PluginFault]) -> PluginFault:
    names = ", ".join(other.name for other in others[:_MOST_OTHERS])
    more = f", and {len(others) - _MOST_OTHERS} more" if len(others) > _MOST_OTHERS else ""
    plugins = "1 other plug-in" if len(others) == 1 else f"{len(others)} other plug-ins"
    return replace(fault, reason=f"{fault.reason} (the same breaks {plugins}: {names}{more})")


_MOST_OTHERS = 10
