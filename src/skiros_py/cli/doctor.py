"""``skiros doctor``: explains an environment; each check looks at one thing and says what to do about it."""

from __future__ import annotations

import os
import platform
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib.metadata import PackageNotFoundError, metadata, requires, version
from pathlib import Path
from typing import Any

import click

from skiros_py.cli.options import JSON, data_option
from skiros_py.cli.output import NOT_REACHED, REACHED, answer
from skiros_py.errors import FileError, SkirosError, UnknownName, escaped, without_wheels
from skiros_py.system import (
    EXTRAS,
    check_display,
    has_extra,
    memory,
    missing_system_libraries,
    processors,
    this_platform,
)


@dataclass(frozen=True, slots=True)
class Finding:
    """The result of a check.

    Attributes:
        text: What was found.
        todo: What to do about it; empty if all is well.
        optional: Whether everything works without it.
    """

    text: str
    todo: str = ""
    optional: bool = False

    @property
    def state(self) -> str:
        """State in one word: "ok", "note" or "wrong"."""
        return "ok" if not self.todo else "note" if self.optional else "wrong"


Check = Callable[[], Iterator[Finding]]

CHECKS: dict[str, Check] = {}
"""All checks by name, in the order in which they run."""

_LEAST_MEMORY = 4 * 2**30
_DOMAIN = """
(define (domain try) (:requirements :strips) (:predicates (done) (ready))
  (:action act :parameters () :precondition (ready) :effect (done)))
"""
_PROBLEM = "(define (problem try) (:domain try) (:init (ready)) (:goal (done)))"


def _check(name: str) -> Callable[[Check], Check]:
    return lambda check: CHECKS.setdefault(name, check)


@_check("python")
def _python() -> Iterator[Finding]:
    from packaging.specifiers import SpecifierSet

    wanted, own = metadata("skiros-py")["Requires-Python"] or "", platform.python_version()
    fits = SpecifierSet(wanted).contains(own, prereleases=True)
    yield Finding(f"Python {own} ({sys.executable})", "" if fits else f"use a Python {wanted}")


@_check("skiros-py")
def _skiros() -> Iterator[Finding]:
    yield Finding(f"skiros-py {version('skiros-py')} in {Path(__file__).parents[1]}")


@_check("libraries")
def _libraries() -> Iterator[Finding]:
    """Checks that the required libraries are installed in compatible versions."""
    from packaging.requirements import Requirement

    wanted = [Requirement(text) for text in requires("skiros-py") or ()]
    for requirement in (r for r in wanted if r.marker is None or r.marker.evaluate({"extra": ""})):
        todo = f"pip install '{requirement}'"
        try:
            found = version(requirement.name)
        except PackageNotFoundError:
            yield Finding(f"{requirement.name} is not installed", todo)
        else:
            if not requirement.specifier.contains(found, prereleases=True):
                yield Finding(f"{requirement.name} {found} does not fit {requirement.specifier}", todo)


@_check("extras")
def _extras() -> Iterator[Finding]:
    """Reports the extras, and one command for all that are missing and can be installed here."""
    missing = [extra for extra in EXTRAS if not has_extra(extra)]
    yield Finding(f"installed: {', '.join(extra for extra in EXTRAS if extra not in missing) or 'none'}")
    possible = [extra for extra in missing if not without_wheels(extra)]
    if possible:
        todo = f"python3 -m pip install 'skiros-py[{','.join(possible)}]'"
        yield Finding(f"not installed: {', '.join(possible)}", todo, optional=True)
    for extra in (extra for extra in missing if extra not in possible):
        text = f"{extra}: not for {this_platform()} ({', '.join(without_wheels(extra))})"
        yield Finding(text, "use Python 3.11 on x86-64 Linux", optional=True)


@_check("system")
def _system() -> Iterator[Finding]:
    for missing in dict.fromkeys(missing_system_libraries()):
        yield Finding(str(missing), f"apt-get install {missing.package}")


@_check("machine")
def _machine() -> Iterator[Finding]:
    text = f"{processors()} processors, {memory() / 2**30:.1f} GiB of memory"
    little = processors() < 2 or memory() < _LEAST_MEMORY
    yield Finding(text, "runs with physics want 2 processors and 4 GiB" if little else "", optional=True)


@_check("folders")
def _folders() -> Iterator[Finding]:
    try:
        with tempfile.TemporaryFile() as file:
            file.write(b"-")
    except OSError as error:
        yield Finding(f"{tempfile.gettempdir()}: {error.strerror}", "set TMPDIR to a folder that can be written")
    for variable in ("SKIROS_ONTOLOGIES", "SKIROS_SCENES"):
        for path in filter(None, os.environ.get(variable, "").split(":")):
            if not Path(path).exists():
                yield Finding(f"{variable} names {path}, which does not exist", f"correct {variable}")


def data_folder(folder: Path) -> Iterator[Finding]:
    """Checks that a folder, which may not exist yet, can be a data directory."""
    there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not there.is_dir():
        yield Finding(f"{there} is no folder", "choose another with --data")
    elif not os.access(there, os.W_OK | os.X_OK):
        yield Finding(f"{there} cannot be written", "choose another with --data, or change its owner")
    else:
        yield Finding(f"{folder} can be written")


@_check("java")
def _java() -> Iterator[Finding]:
    from skiros_py.world.ontology.check.owl_reasoner import java

    path = java()
    todo = "optional: skiros ontology check asks HermiT where there is a Java; apt-get install default-jre-headless"
    yield Finding(f"{path}") if path else Finding("there is no Java", todo, optional=True)


@_check("display")
def _display() -> Iterator[Finding]:
    try:
        check_display(os.environ.get("DISPLAY"))
    except (SkirosError, OSError) as error:
        yield Finding(str(error), "optional: only skiros run --gui wants one", optional=True)


@_check("planner")
def _planner() -> Iterator[Finding]:
    """Solves a small task, to check that the planner's programs start."""
    from contextlib import closing

    from skiros_py.planning.planners.fast_downward import FastDownward
    from skiros_py.planning.planners.planner import Solved

    todo = "pip install --force-reinstall up-fast-downward"
    try:
        with closing(FastDownward(time_limit=30.0)) as planner:
            found = planner.solve(_DOMAIN, _PROBLEM).result()
    except (SkirosError, OSError) as error:
        yield Finding(f"{error}", todo)
    else:
        solved = isinstance(found, Solved)
        yield Finding("Fast Downward plans") if solved else Finding(f"Fast Downward answers {found}", todo)


@_check("plug-ins")
def _distributions() -> Iterator[Finding]:
    from skiros_py.plugins.installation import installation

    found = installation()
    for distribution in found.distributions:
        number = sum(entry.distribution == distribution for entry in found.entries)
        yield Finding(f"{distribution}: {number} entry points ({distribution.folder})")
    for fault in found.faults:
        yield Finding(f"{fault.distribution}: {fault.reason}", f"install it again, or remove {fault.origin}")


@_check("versions")
def _versions() -> Iterator[Finding]:
    from skiros_py.plugins.installation import installation, misfit

    for distribution in installation().distributions:
        if found := misfit(distribution):
            yield Finding(f"{distribution}: {found.problem}", found.todo)


@_check("stale entry points")
def _stale() -> Iterator[Finding]:
    from skiros_py.plugins.installation import installation
    from skiros_py.plugins.plugin import locate

    for entry in installation().entries:
        name = entry.distribution.name
        if not entry.is_well_formed:
            yield Finding(f"{entry.group} {entry.name} of {entry} names nothing", "write module:object")
        elif locate(entry.module) is None:
            todo = f"pip install --force-reinstall {name}, or pip uninstall {name}"
            yield Finding(f"{entry.group} {entry.name} of {entry}: the module is gone", todo)


@_check("unknown groups")
def _groups() -> Iterator[Finding]:
    from skiros_py.plugins.installation import GROUPS, installation

    for entry in (one for one in installation().entries if one.group not in GROUPS):
        text = f"{entry.name} of {entry}: {UnknownName('group of entry points', entry.group, GROUPS)}"
        todo = "nothing reads it; correct the group in the metadata of its distribution"
        yield Finding(text, todo, optional=True)


@_check("loading")
def _loading() -> Iterator[Finding]:
    """Loads all plug-ins."""
    from skiros_py.catalogue import survey
    from skiros_py.plugins.installation import GROUPS
    from skiros_py.plugins.plugin import by_cause

    faults = (fault for one in survey()[0] if one.entry.group in GROUPS for fault in one.faults)
    for fault in by_cause(faults):
        text = f"{fault.group} {fault.name} of {fault.distribution}: {fault.reason}"
        yield Finding(text, f"skiros plugins {fault.name} shows it in full")


@_check("ontologies")
def _ontologies() -> Iterator[Finding]:
    from skiros_py.config import ontology_paths
    from skiros_py.world.ontology import load_installed

    try:
        found, _ = load_installed(ontology_paths())
    except FileError as error:
        yield Finding(str(error), "correct the file; skiros ontology check says more")
    else:
        numbers = f"{len(found.classes)} classes, {len(found.relations)} relations"
        yield Finding(f"{len(found.sources)} files go together: {numbers}")


@_check("scenes")
def _scenes() -> Iterator[Finding]:
    from skiros_py.config import named_scene, ontology_paths, scene_names
    from skiros_py.world.ontology import load_installed
    from skiros_py.world.reasoners.registry import load_reasoners
    from skiros_py.world.scene.files import load_scene

    ontology, _ = load_installed(ontology_paths())
    reasoners, _ = load_reasoners(ontology)
    for name in scene_names():
        try:
            load_scene(ontology, named_scene(name), ontology_paths(), reasoners=reasoners)
        except SkirosError as error:
            yield Finding(f"{name}: {error}", f"correct it; skiros scene check {name} tries again")
    yield Finding(f"{len(scene_names())} scenes: {', '.join(scene_names())}")


@click.command("doctor", epilog="Example: skiros doctor --json")
@data_option(required=False)
@JSON
def command(data: Path | None, as_json: bool) -> int:
    """Checks this environment: Python, libraries, plug-ins, ontologies, scenes, planner; says how to fix faults.

    Exit status: 0 nothing is wrong (what is optional and absent is noted), 1 something is.
    """
    found: list[dict[str, Any]] = []
    checks = CHECKS | ({} if data is None else {"data": partial(data_folder, data)})
    for name, finding in ((name, finding) for name, check in checks.items() for finding in examined(check)):
        found.append({"check": name, "state": finding.state, "text": finding.text, "todo": finding.todo})
        if not as_json:
            click.echo(escaped(f"{finding.state:5}  {name:18}  {finding.text}"))
            if finding.todo:
                click.echo(escaped(f"{'':27}do: {finding.todo}"))
    status = NOT_REACHED if any(one["state"] == "wrong" for one in found) else REACHED
    if as_json:
        answer({"checks": found, "status": status})
    elif status == REACHED:
        click.echo("nothing is wrong")
    return status


def examined(check: Check) -> Iterator[Finding]:
    """Runs one check; an exception is reported, and the other checks still run.

    Yields:
        Its findings; if there are none, that nothing is wrong.
    """
    finding = None
    try:
        for finding in check():
            yield finding
    except (GeneratorExit, KeyboardInterrupt):
        raise
    except BaseException as error:  # noqa: BLE001 - an environment can be broken in any way
        yield Finding(f"the check itself broke: {type(error).__name__}: {error}", "see the other lines")
    else:
        if finding is None:
            yield Finding("nothing wrong")
