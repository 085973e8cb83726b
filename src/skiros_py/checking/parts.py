"""The contents of distributions: every skill, primitive and condition with its location, and the source files."""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

from skiros_py.catalogue.kinds import KINDS, skills_of
from skiros_py.plugins import Entry, Plugin, PluginFault, examined, load
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.lint import Source, Spot, Subject
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill

_OWN_PACKAGE = "skiros_py"


@dataclass(frozen=True, slots=True)
class Part:
    """One skill, primitive or condition of a distribution.

    Attributes:
        entry: The entry point that names it.
        subject: The object.
        spot: Its location in the source, or None if unknown.
    """

    entry: Entry
    subject: Subject
    spot: Spot | None


def parts_of(entries: Iterable[Entry]) -> tuple[Part, ...]:
    """Loads entry points; broken ones, and those without code, yield no parts."""
    parts: list[Part] = []
    described: list[object] = []
    for entry in entries:
        plugin = load(entry) if entry.group in _WITH_SUBJECTS else None
        if not isinstance(plugin, Plugin) or isinstance(examined(plugin, KINDS[entry.group].problem), PluginFault):
            continue
        for subject in _subjects(plugin):
            if not any(subject is one for one in described):  # several implementations share one description
                described.append(subject)
                parts.append(Part(entry, subject, _spot(entry, subject)))
    return tuple(parts)


_WITH_SUBJECTS = ("skiros.skills", "skiros.primitives", "skiros.conditions")


def _subjects(plugin: Plugin) -> Iterator[Subject]:
    if plugin.group == "skiros.skills":
        for skill in skills_of(plugin).values():
            yield from (skill.description, skill)
    else:
        yield plugin.value


def sources_of(parts: Sequence[Part], entries: Iterable[Entry]) -> tuple[Source, ...]:
    """Reads the Python files of the packages that entry points name, without those of the platform itself."""
    tops = {entry.module.partition(".")[0] for entry in entries} - {_OWN_PACKAGE, ""}
    files = sorted({file for top in tops for file in _files(top)})
    modules = {Path(str(m.__file__)).resolve(): m for m in list(sys.modules.values()) if getattr(m, "__file__", None)}
    written = {file for part in parts if isinstance(part.subject, type) for file in _homes(part.subject)}
    return tuple(s for file in files if (s := _source(file, modules.get(file), file in written)) is not None)


def _files(top: str) -> Iterator[Path]:
    module = sys.modules.get(top)
    for folder in getattr(module, "__path__", ()):
        yield from (file.resolve() for file in Path(folder).rglob("*.py"))
    if module is not None and not hasattr(module, "__path__") and getattr(module, "__file__", None):
        yield Path(str(module.__file__)).resolve()


def _homes(class_: type) -> Iterator[Path]:
    """Yields the files that define a primitive and its own base classes."""
    for base in class_.__mro__:
        if issubclass(base, Primitive) and base is not Primitive:
            module = sys.modules.get(base.__module__)
            if module is not None and getattr(module, "__file__", None):
                yield Path(str(module.__file__)).resolve()


def _source(file: Path, module: ModuleType | None, has_primitives: bool) -> Source | None:
    try:
        return Source(file, file.read_text(encoding="utf-8"), vars(module) if module else {}, has_primitives)
    except (OSError, UnicodeDecodeError, SyntaxError):
        return None  # its importer does not load, which is reported


def _spot(entry: Entry, subject: Subject) -> Spot | None:
    if isinstance(subject, type):
        return _class_spot(subject)
    module: Any = sys.modules.get(entry.module)
    if module is None or not getattr(module, "__file__", None):
        return None
    name = next((n for n, value in vars(module).items() if value is subject), "")
    if not name and isinstance(subject, Skill | ConditionType):
        name = entry.attribute.partition(".")[0]
    file = Path(module.__file__)
    return Spot(file, _lines(file).get(name) or _lines(file).get(entry.attribute, 1))


def _class_spot(class_: type) -> Spot | None:
    try:
        file, line = inspect.getsourcefile(class_), inspect.getsourcelines(class_)[1]
    except (OSError, TypeError):
        return None
    return Spot(Path(file), line) if file else None


@lru_cache(maxsize=64)
def _lines(file: Path) -> dict[str, int]:
    """Returns the line of each name that a module assigns."""
    try:
        tree = ast.parse(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, SyntaxError):
        return {}
    found: dict[str, int] = {}
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        found |= {target.id: node.lineno for target in targets if isinstance(target, ast.Name)}
    return found
