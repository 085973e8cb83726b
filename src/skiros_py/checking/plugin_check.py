"""Checks all plug-ins of a distribution: loading, rules, and contract tests of its skills."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType

from skiros_py.catalogue.loading import load_catalogue
from skiros_py.catalogue.survey import survey
from skiros_py.checking.cases import Ground
from skiros_py.checking.contract import Contract, check_contract, is_testable
from skiros_py.checking.parts import Part, parts_of, sources_of
from skiros_py.checking.simulated import check_simulated, is_simulable
from skiros_py.config import find_scene, ontology_paths, scene_names
from skiros_py.errors import SkirosError, UnknownName
from skiros_py.plugins import Entry, PluginFault, installation
from skiros_py.plugins.installation import canonical
from skiros_py.plugins.origin import authors_line
from skiros_py.skills.lint import DOES_NOT_LOAD, RULES, Finding, Known, Rule, Severity, Spot, check, title
from skiros_py.skills.lint.rules.calls import MISSING_PARAMETER
from skiros_py.skills.skill import Skill
from skiros_py.world.ontology import Ontology, load_installed
from skiros_py.world.reasoners.plugins import load_reasoners
from skiros_py.world.reasoners.registry import Reasoners
from skiros_py.world.scene import load_scene
from skiros_py.world.world import World


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
    wanted = _chosen(rules)
    entries = _entries(distribution)
    every = parts_of(installation().entries)
    parts = [part for part in every if part.entry in entries]
    progress("asking the rules")
    known = _known(every)
    findings = [*_asked(parts, entries, known, wanted.values()), *_broken(entries, parts, wanted)]
    tests = _contracts(parts, known, entries) if run else {}
    tests = {**tests, **(_simulations(parts, simulate) if run and simulate is not None else {})}
    contracts = tuple(_run(tests, progress))
    findings += [finding for contract in contracts for finding in contract.findings if finding.rule in wanted]
    names = tuple(sorted({str(entry.distribution) for entry in entries}))
    ran = [contract.skill for contract in contracts]
    not_run = tuple(skill for skill in _skills(parts) if run and not any(skill is one for one in ran))
    return PluginReport(names, len(parts), tuple(sorted(set(findings), key=_order)), contracts, not_run)


def _chosen(names: Iterable[str]) -> dict[str, Rule]:
    chosen = tuple(names)
    for name in chosen:
        if name not in RULES:
            raise UnknownName("rule", name, RULES)
    return {name: rule for name, rule in RULES.items() if not chosen or name in chosen}


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
    return Known(ontology, primitives, _skills(parts), reasoners)


def _skills(parts: Iterable[Part]) -> tuple[Skill, ...]:
    return tuple(part.subject for part in parts if isinstance(part.subject, Skill))


def _asked(parts: Sequence[Part], entries: Sequence[Entry], known: Known, rules: Collection[Rule]) -> Iterator[Finding]:
    for part in parts:
        yield from check(part.subject, known, part.spot, rules)
    for source in sources_of(parts, entries):
        yield from check(source, known, None, rules)


def _order(finding: Finding) -> tuple[str, int, str, str]:
    spot = finding.spot
    return (str(spot.file) if spot else "", spot.line if spot else 0, finding.rule, finding.text)


# -------------------------------------------------------------------- loading


def _broken(entries: Sequence[Entry], parts: Sequence[Part], rules: Collection[str]) -> Iterator[Finding]:
    """Yields plug-ins that could not be loaded; for skills that could, the rules report faults in more detail."""
    loaded = {(part.entry.group, part.entry.name) for part in parts}
    _, loose = surveyed = survey()
    for one in surveyed[0]:
        if one.entry in entries and (one.entry.group, one.entry.name) not in loaded:
            yield from (f for fault in one.faults if (f := _not_loaded(fault)).rule in rules)
    names = {str(entry.distribution) for entry in entries}
    yield from (f for fault in loose if fault.distribution in names and (f := _not_loaded(fault)).rule in rules)


def _not_loaded(fault: PluginFault) -> Finding:
    is_stray = fault.reason.startswith("UnknownName: unknown parameter")
    rule = MISSING_PARAMETER if is_stray else DOES_NOT_LOAD
    subject = f"{fault.group.partition('.')[2].removesuffix('s')} {fault.name}"
    return Finding(rule.name, rule.severity, subject, fault.reason, _raised_at(fault))


def _raised_at(fault: PluginFault) -> Spot | None:
    """Returns the last line of the plug-in's own code in a traceback."""
    frame = authors_line(fault.traceback)
    if frame is not None:
        return Spot(frame[0], frame[1])
    return Spot(Path(fault.origin), 1) if fault.origin else None


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
    grounds = scene_grounds(known.ontology, known.reasoners, own_scenes)
    found: dict[str, Callable[[], Contract]] = {}
    for part in parts:
        if isinstance(part.subject, Skill) and is_testable(part.subject):
            name = part.entry.name if part.entry.name not in found else f"{part.entry.name}[{len(found)}]"
            found[name] = partial(check_contract, part.subject, grounds, known.skills, known.primitives, part.spot)
    return MappingProxyType(found)


def _simulations(parts: Sequence[Part], scene: str) -> Mapping[str, Callable[[], Contract]]:
    find_scene(scene)  # reports a misspelt name before the first trial
    catalogue = load_catalogue()
    simulable = [(part, part.subject) for part in parts if isinstance(part.subject, Skill)]
    return {
        f"{title(skill)} in {scene}": partial(check_simulated, skill, scene, catalogue, part.spot)
        for part, skill in simulable
        if is_simulable(skill)
    }


def _run(contracts: Mapping[str, Callable[[], Contract]], progress: Callable[[str], None]) -> Iterator[Contract]:
    for name, run in contracts.items():
        progress(f"trying {name}")
        yield run()


# ---------------------------------------------------------------- the worlds that trials start from: the scenes at hand


def scene_grounds(ontology: Ontology, reasoners: Reasoners, first: Collection[str] = ()) -> tuple[Ground, ...]:
    """Returns all scenes, those of the given names first."""
    names = sorted(scene_names(), key=lambda name: (name not in first, name))
    return tuple(_grounds(names, ontology, reasoners))


def _grounds(names: Collection[str], ontology: Ontology, reasoners: Reasoners) -> Iterator[Ground]:
    for name in names:
        try:
            yield Ground(name, partial(_open, ontology, find_scene(name), reasoners))
        except SkirosError:
            continue  # a broken scene of a plug-in is reported as such


def _open(ontology: Ontology, file: Path, reasoners: Reasoners) -> World:
    return load_scene(ontology, file, ontology_paths(), reasoners=reasoners)
