"""Checks all plug-ins of a distribution, or of a folder: loading, rules, and contract tests of its skills."""

from __future__ import annotations

import inspect
import re
import sys
import tomllib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any

from skiros_py.catalogue.loading import KINDS, load_catalogue, skills_of, survey
from skiros_py.checking.cases import Ground
from skiros_py.checking.contract import Contract, check_contract, check_simulated, is_simulable, is_testable
from skiros_py.config import find_scene, ontology_paths, scene_names
from skiros_py.errors import FileError, SkirosError, UnknownName
from skiros_py.plugins.installation import as_if_installed, installation
from skiros_py.plugins.loading import load
from skiros_py.plugins.plugin import Entry, Plugin, PluginFault, authors_line, by_cause, canonical
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.lint.checking import DOES_NOT_LOAD, RULES, check
from skiros_py.skills.lint.rule import Finding, Known, Severity, Source, Spot, Subject, title
from skiros_py.skills.lint.rules.calls import missing_parameter
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.world.ontology import Ontology, load_installed
from skiros_py.world.reasoners.registry import Reasoners, load_reasoners
from skiros_py.world.scene.files import load_scene


@contextmanager
def as_installed(path: Path) -> Iterator[str]:
    """Registers the package in a folder as if it were installed; yields its name.

    Raises:
        FileError: The folder has no ``pyproject.toml`` that describes a package with plug-ins.
    """
    project = _project(path)
    source = path / "src" if (path / "src").is_dir() else path
    with as_if_installed(project, source.resolve()):
        yield str(project["name"])


def _project(path: Path) -> Mapping[str, Any]:
    file = path / "pyproject.toml"
    try:
        project: dict[str, Any] = tomllib.loads(file.read_text(encoding="utf-8")).get("project", {})
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise FileError(file, f"cannot be read: {reason}; give the folder of a package") from error
    except tomllib.TOMLDecodeError as error:
        raise FileError(file, f"is no TOML: {error}") from error
    points = project.get("entry-points", {})
    if "name" not in project or not any(group.startswith("skiros.") for group in points):
        raise FileError(file, "names no plug-ins: it needs a name and entry points such as 'skiros.skills'")
    return project


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
        plugin = load(entry, KINDS[entry.group].problem) if entry.group in _WITH_SUBJECTS else None
        if not isinstance(plugin, Plugin):
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
            yield from skill.primitives
    else:
        yield plugin.value


def sources_of(parts: Sequence[Part], entries: Iterable[Entry]) -> tuple[Source, ...]:
    """Reads the Python files of the packages that entry points name, without those of the platform itself."""
    tops = {entry.module.partition(".")[0] for entry in entries} - {_OWN_PACKAGE, ""}
    files = sorted({file for top in tops for file in _files(top)})
    modules = {file: module for module in list(sys.modules.values()) if (file := _file_of(module)) is not None}
    written = {file for part in parts if isinstance(part.subject, type) for file in _homes(part.subject)}
    return tuple(s for file in files if (s := _source(file, modules.get(file), file in written)) is not None)


def _file_of(module: ModuleType | None) -> Path | None:
    file = getattr(module, "__file__", None)
    return Path(file).resolve() if file else None


def _files(top: str) -> Iterator[Path]:
    module = sys.modules.get(top)
    for folder in getattr(module, "__path__", ()):
        yield from (file.resolve() for file in Path(folder).rglob("*.py"))
    if not hasattr(module, "__path__") and (file := _file_of(module)):
        yield file


def _homes(class_: type) -> Iterator[Path]:
    """Yields the files that define a primitive and its own base classes."""
    own = (base for base in class_.__mro__ if issubclass(base, Primitive) and base is not Primitive)
    yield from filter(None, (_file_of(sys.modules.get(base.__module__)) for base in own))


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
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return Spot(file, 1)
    places = (
        re.search(rf"^(class )?{re.escape(one)}\b[^=\n]*[=:]", text, re.MULTILINE)
        for one in (name, entry.attribute)
        if one
    )
    found = next(filter(None, places), None)
    return Spot(file, 1 if found is None else text.count("\n", 0, found.start()) + 1)


def _class_spot(class_: type) -> Spot | None:
    try:
        file, line = inspect.getsourcefile(class_), inspect.getsourcelines(class_)[1]
    except (OSError, TypeError):
        return None
    return Spot(Path(file), line) if file else None


@dataclass(frozen=True, slots=True)
class PluginReport:
    """The result of a check.

    Attributes:
        distributions: The checked distributions, with their versions.
        parts: Number of checked skills, primitives and conditions.
        findings: The findings, by file and line.
        contracts: The contract tests.
        not_run: Implementations without a contract test, because it would need a real or a simulated robot; empty if
            nothing was to be run.
    """

    distributions: tuple[str, ...]
    parts: int
    findings: tuple[Finding, ...]
    contracts: tuple[Contract, ...]
    not_run: tuple[Skill, ...] = ()

    @property
    def errors(self) -> int:
        """Number of findings that are errors."""
        return sum(finding.severity is Severity.ERROR for finding in self.findings)


def check_plugins(
    distribution: str | None = None,
    rules: Collection[str] = (),
    *,
    run: bool = True,
    simulate: str | None = None,
    progress: Callable[[str], None] = lambda _text: None,
) -> PluginReport:
    """Checks the plug-ins of one distribution, or of all that are installed.

    Args:
        distribution: Its name; None for all.
        rules: Names of the rules to apply; all if omitted.
        run: Whether skills are run by contract tests.
        simulate: Name or path of a scene in which skills not for fakes are run in physics; None to run none.
        progress: Called with a description of each step.

    Raises:
        UnknownName: There is no such distribution with plug-ins, no such rule, or no such scene.
        FileError: An ontology of the installation cannot be read.
    """
    if unknown := next((name for name in rules if name not in RULES), None):
        raise UnknownName("rule", unknown, RULES)
    wanted = {name: rule for name, rule in RULES.items() if not rules or name in rules}
    entries = _entries(distribution)
    every = parts_of(installation().entries)
    parts = [part for part in every if part.entry in entries]
    progress("asking the rules")
    known = _known(every)
    subjects = [*((part.subject, part.spot) for part in parts), *((s, None) for s in sources_of(parts, entries))]
    findings = [finding for subject, spot in subjects for finding in check(subject, known, spot, wanted.values())]
    findings += _broken(entries, parts, wanted)
    tests = _contracts(parts, known, entries) if run else {}
    tests = {**tests, **(_simulations(parts, simulate) if run and simulate is not None else {})}
    contracts = []
    for name, run_contract in tests.items():
        progress(f"trying {name}")
        contracts.append(run_contract())
    findings += [finding for contract in contracts for finding in contract.findings if finding.rule in wanted]
    names = tuple(sorted({str(entry.distribution) for entry in entries}))
    ran = [contract.skill for contract in contracts]
    not_run = tuple(skill for skill in _skills(parts) if run and not any(skill is one for one in ran))
    return PluginReport(names, len(parts), tuple(sorted(set(findings), key=_order)), tuple(contracts), not_run)


def _entries(distribution: str | None) -> tuple[Entry, ...]:
    everything = installation().entries
    if distribution is None:
        return everything
    own = tuple(e for e in everything if canonical(e.distribution.name) == canonical(distribution))
    if not own:
        known = {entry.distribution.name for entry in everything}
        raise UnknownName("distribution with plug-ins", distribution, known)
    return own


def _known(parts: Sequence[Part]) -> Known:
    ontology, _ = load_installed(ontology_paths())
    reasoners, _ = load_reasoners(ontology)
    primitives = {part.entry.name: part.subject for part in parts if isinstance(part.subject, type)}
    primitives |= {one.name: one for skill in _skills(parts) for one in skill.primitives}
    return Known(ontology, primitives, _skills(parts), reasoners)


def _skills(parts: Iterable[Part]) -> tuple[Skill, ...]:
    return tuple(part.subject for part in parts if isinstance(part.subject, Skill))


def _order(finding: Finding) -> tuple[str, int, str, str]:
    spot = finding.spot
    return (str(spot.file) if spot else "", spot.line if spot else 0, finding.rule, finding.text)


# -------------------------------------------------------------------- loading


def _broken(entries: Sequence[Entry], parts: Sequence[Part], rules: Collection[str]) -> Iterator[Finding]:
    """Yields plug-ins that could not be loaded; for skills that could, the rules report faults in more detail."""
    loaded = {(part.entry.group, part.entry.name) for part in parts}
    _, loose = surveyed = survey()
    names = {str(entry.distribution) for entry in entries}
    faults = [fault for fault in loose if fault.distribution in names]
    for one in surveyed[0]:
        if one.entry in entries and (one.entry.group, one.entry.name) not in loaded:
            faults += one.faults
    yield from (found for fault in by_cause(faults) if (found := _not_loaded(fault)).rule in rules)


def _not_loaded(fault: PluginFault) -> Finding:
    rule = missing_parameter if fault.unknown == "parameter" else DOES_NOT_LOAD
    subject = f"{fault.group.partition('.')[2].removesuffix('s')} {fault.name}"
    return Finding(rule.name, rule.severity, subject, fault.reason, _raised_at(fault))


def _raised_at(fault: PluginFault) -> Spot | None:
    """Returns where a fault is: the last line of the plug-in's own code in a traceback, if it has one."""
    frame = authors_line(fault.traceback)
    if frame is not None:
        return Spot(frame[0], frame[1])
    return Spot(Path(fault.origin), fault.line or 1) if fault.origin else None


# -------------------------------------------------------------------- contract tests


def own_contracts(distribution: str) -> Mapping[str, Callable[[], Contract]]:
    """Returns the contract test of each skill of a distribution that can be run on a fake, by entry point.

    Raises:
        UnknownName: There is no such distribution with plug-ins.
        FileError: An ontology of the installation cannot be read.
    """
    entries = _entries(distribution)
    every = parts_of(installation().entries)
    return _contracts([part for part in every if part.entry in entries], _known(every), entries)


def _contracts(parts: Sequence[Part], known: Known, entries: Sequence[Entry]) -> Mapping[str, Callable[[], Contract]]:
    own_scenes = [entry.name for entry in entries if entry.group == "skiros.scenes"]
    grounds = tuple(scene_grounds(known.ontology, known.reasoners, own_scenes))
    found: dict[str, Callable[[], Contract]] = {}
    for part in parts:
        if isinstance(part.subject, Skill) and is_testable(part.subject):
            name = part.entry.name if part.entry.name not in found else f"{part.entry.name}[{len(found)}]"
            found[name] = partial(check_contract, part.subject, grounds, known.skills, known.primitives, part.spot)
    return MappingProxyType(found)


def _simulations(parts: Sequence[Part], scene: str) -> Mapping[str, Callable[[], Contract]]:
    find_scene(scene)  # reports a misspelt name before the first trial
    catalogue = load_catalogue()
    return {
        f"{title(part.subject)} in {scene}": partial(check_simulated, part.subject, scene, catalogue, part.spot)
        for part in parts
        if isinstance(part.subject, Skill) and is_simulable(part.subject)
    }


# ---------------------------------------------------------------- the worlds that trials start from: the scenes at hand


def scene_grounds(ontology: Ontology, reasoners: Reasoners, first: Collection[str] = ()) -> Iterator[Ground]:
    """Yields all scenes, those of the given names first."""
    for name in sorted(scene_names(), key=lambda name: (name not in first, name)):
        with suppress(SkirosError):  # a broken scene of a plug-in is reported as such
            file = find_scene(name)
            yield Ground(name, partial(load_scene, ontology, file, ontology_paths(), reasoners=reasoners))
