"""What is known of a plug-in: before it is loaded, once it is, and when it cannot be."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from skiros_py.plugins.origin import origin_of

_REFERENCE = re.compile(r"\s*([\w.]+)\s*(?::\s*([\w.]+)\s*)?(?:\[.*\]\s*)?")


@dataclass(frozen=True, slots=True)
class Distribution:
    """What pip installed together.

    Attributes:
        name: Its name ("skiros-skills").
        version: Its version; empty where its metadata are gone.
        requires: What it requires, as its metadata say ("skiros-py>=0.1,<0.2").
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
        name: Entry-point name.
        value: What it names ("skiros_skills.drive:DRIVE").
        distribution: What brings it.
    """

    group: str
    name: str
    value: str
    distribution: Distribution

    @property
    def is_well_formed(self) -> bool:
        """True where it names a module, or something in one."""
        return _REFERENCE.fullmatch(self.value) is not None

    @property
    def module(self) -> str:
        """The module that it names; empty where it is not well-formed."""
        match = _REFERENCE.fullmatch(self.value)
        return match[1] if match else ""

    @property
    def attribute(self) -> str:
        """What it names in the module; empty for the module itself."""
        match = _REFERENCE.fullmatch(self.value)
        return (match[2] or "") if match else ""

    def __str__(self) -> str:
        return f"{self.distribution} ({self.value})"


@dataclass(frozen=True, slots=True)
class Plugin:
    """One loaded entry point.

    Attributes:
        group: Entry-point group ("skiros.skills").
        name: Entry-point name.
        distribution: Distribution that brings it, with its version ("skiros-skills 0.1.0").
        value: The object it names.
        module: The module it was found in.
    """

    group: str
    name: str
    distribution: str
    value: Any
    module: str = ""

    def fault(self, reason: str, traceback: str = "") -> PluginFault:
        """Makes the fault that says why it cannot be used."""
        origin = origin_of(self.module)
        return PluginFault(self.group, self.name, self.distribution, reason, traceback, origin)


@dataclass(frozen=True, slots=True)
class PluginFault:
    """An entry point that could not be loaded or used, with the traceback for its author.

    Attributes:
        group: Entry-point group.
        name: Entry-point name.
        distribution: Distribution that brings it, with its version.
        reason: What is wrong.
        traceback: Where it was raised; empty where nothing was.
        origin: File of the module it names; empty where it has none.
    """

    group: str
    name: str
    distribution: str
    reason: str
    traceback: str
    origin: str = ""

    def __str__(self) -> str:
        return f"plug-in {self.name} of {self.distribution} did not load: {self.reason}"
