"""``skiros ontology``: check and show ontologies, and write their words as Python constants."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skiros_py.cli.commands import Found, reports
from skiros_py.cli.options import IMPORTS, combined, time_limit_option
from skiros_py.cli.output import NOT_REACHED, REACHED, counted, progress
from skiros_py.errors import UsageError
from skiros_py.files import read_text

if TYPE_CHECKING:
    from skiros_py.world.ontology import Ontology
    from skiros_py.world.ontology.check.checking import CheckReport, ReasonerChoice
    from skiros_py.world.terms import End

_PATHS = combined(click.argument("paths", nargs=-1, type=click.Path(exists=True, path_type=Path)), IMPORTS)


@click.group("ontology")
def command() -> None:
    """Lists and checks ontologies, and generates Python constants for their terms.

    PATHS are files and folders; left out, they are the ontologies of the installation. What they import is looked up
    among them, in the folders of --imports and SKIROS_IMPORTS, and never fetched.
    """


@reports("ontology check my.ttl ontologies/core.ttl --reasoner owl-rl", command)
@_PATHS
@click.option(
    "--reasoner",
    type=click.Choice(["auto", "hermit", "owl-rl", "none"]),
    default="auto",
    help="hermit sees most and needs Java; owl-rl needs none; auto takes the best there is.  [default: auto]",
)
@time_limit_option(60.0, "Time limit of a reasoner")
def check(paths: tuple[Path, ...], reasoner: ReasonerChoice, time_limit: float) -> Found:
    """Checks the ontologies PATHS together, as they would be loaded.

    Finds undeclared terms, bad domains and ranges, cycles, classes that nothing can be of and contradictions, each
    with its file and line, and with the statements that together make it so.

    Exit status: 0 no errors (there may be warnings), 1 errors, 2 wrong usage.
    """
    from skiros_py.world.ontology.check.checking import check_ontology

    with progress("starting") as shown:
        report = check_ontology(_or_installed(paths), reasoner, time_limit, shown)
    return _as_json(report), _lines(report), NOT_REACHED if report.errors else REACHED


@command.command("constants", epilog="Example: skiros ontology constants --namespace kitting -o kitting.py")
@_PATHS
@click.option("--namespace", "namespaces", multiple=True, metavar="PREFIX", help="Terms to write; may be repeated.")
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE", help="Write to FILE.")
@click.option(
    "--check",
    "current",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write nothing; show what FILE lacks and end with 1 where it is not current.",
)
def constants(paths: tuple[Path, ...], namespaces: tuple[str, ...], output: Path | None, current: Path | None) -> int:
    """Writes a typed Python module of the classes, relations, properties and individuals of PATHS.

    A wrong or renamed word then fails at type-check time.
    """
    from skiros_py.world.ontology import Ontology
    from skiros_py.world.ontology.constants import constants_module
    from skiros_py.world.scene.files import write_atomically

    if output is not None and current is not None:
        raise UsageError("-o writes a file and --check writes none: give one of them")
    text = constants_module(Ontology.load(_or_installed(paths)), namespaces)
    if current is not None:
        return _compare(current, text)
    if output is None:
        click.echo(text, nl=False)
    else:
        write_atomically(output, text)
        click.echo(f"wrote {output}", err=True)
    return REACHED


@reports("ontology list --json", command)
@_PATHS
def list_files(paths: tuple[Path, ...]) -> Found:
    """Lists the files of PATHS with their IRIs and how much each declares."""
    from skiros_py.world.ontology.documents import rdf_files, read_document
    from skiros_py.world.ontology.statements import inventory

    found = [inventory(read_document(path)) for path in rdf_files(_or_installed(paths))]
    return {"files": [{"file": i.path, "iri": i.iri, **i.counts} for i in found]}, (
        line for one in found for line in (str(one.path), f"  <{one.iri}>: {_counted(one.counts) or 'no terms'}")
    )


@reports("ontology tree my.ttl --json", command)
@_PATHS
def tree(paths: tuple[Path, ...]) -> Found:
    """Shows the classes as a tree, each with the relations and properties that it may have.

    Of PATHS, the classes are shown that these files declare, below their superclasses of the installation.
    """
    from skiros_py.world.ontology import Ontology
    from skiros_py.world.ontology.documents import rdf_files
    from skiros_py.world.ontology.statements import Statements
    from skiros_py.world.terms import Kind

    ontology = Ontology.load((*_or_installed(()), *paths))
    own = {path.resolve() for path in rdf_files(paths)} if paths else None
    files = [file for file in ontology.sources if own is None or file.path.resolve() in own]
    declared = Statements(files, ontology.names).declared[Kind.CLASS]
    above = {above for name in declared for above in ontology.ancestors(name)}
    shown = sorted({*declared, *above}, key=lambda name: (name.partition(":")[0] != "sk", name))
    tops = [_branch(ontology, name, shown) for name in shown if ontology.classes[name].primary_parent not in shown]
    anything = _terms_of(ontology, lambda domains: not domains)
    rest = {"class": "anything", "comment": "", "parents": [], "subclasses": [], **anything}
    return {"classes": tops, **anything}, (line for top in (*tops, rest) for line in _drawn(top))


def _branch(ontology: Ontology, name: str, shown: Sequence[str]) -> dict[str, Any]:
    class_ = ontology.classes[name]
    below = (one for one in shown if ontology.classes[one].primary_parent == name)
    return {
        "class": name,
        "comment": class_.comment,
        "parents": list(class_.parents),
        **_terms_of(ontology, lambda domains: any(name in group for group in domains)),
        "subclasses": [_branch(ontology, one, shown) for one in below],
    }


def _terms_of(ontology: Ontology, fits: Callable[[End], bool]) -> dict[str, list[dict[str, Any]]]:
    relations = (one for _, one in sorted(ontology.relations.items()) if fits(one.domains))
    properties = (one for _, one in sorted(ontology.properties.items()) if fits(one.domains))
    return {
        "relations": [
            {"relation": one.curie, "comment": one.comment, "ranges": [*map(list, one.ranges)]} for one in relations
        ],
        "properties": [
            {"property": one.curie, "comment": one.comment, "range": one.range, "unit": one.unit} for one in properties
        ],
    }


def _drawn(branch: Mapping[str, Any], indent: str = "") -> Iterator[str]:
    also = f" (also {', '.join(more)})" if (more := branch["parents"][1:]) else ""
    yield f"{indent}{branch['class']}{also}{_said(branch)}"
    for one in branch["relations"]:
        ends = " and ".join(" or ".join(group) for group in one["ranges"]) or "anything"
        yield f"{indent}  - {one['relation']} -> {ends}{_said(one)}"
    for one in branch["properties"]:
        yield f"{indent}  - {one['property']}: {one['range']}{one['unit'] and ' [' + one['unit'] + ']'}{_said(one)}"
    for below in branch["subclasses"]:
        yield from _drawn(below, f"{indent}    ")


def _said(term: Mapping[str, Any]) -> str:
    return f": {' '.join(term['comment'].split())}" if term["comment"] else ""


def _counted(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{number} {name}" for name, number in counts.items() if number)


def _or_installed(paths: tuple[Path, ...]) -> tuple[Path, ...]:
    """The paths given, else those of the installation and of its plug-ins."""
    if paths:
        return paths
    from skiros_py.config import ontology_paths
    from skiros_py.world.ontology.ontology import plugin_files

    files, faults = plugin_files()
    for fault in faults:
        click.echo(f"did not load: {fault.group} {fault.name} of {fault.distribution}: {fault.reason}", err=True)
    return (*ontology_paths(), *(file for own in files.values() for file in own))


def _lines(report: CheckReport) -> Iterator[str]:
    for finding in report.findings:
        where = f"{finding.file}:{finding.line}: " if finding.line else f"{finding.file}: " if finding.file else ""
        yield f"{where}{finding.severity}: {finding.text} [{finding.kind}]"
        yield from (f"    {statement}" for statement in finding.explanation)
    warnings = len(report.findings) - report.errors
    yield counted(file=len(report.files), error=report.errors, warning=warnings)
    if report.reasoner is None:
        yield f"no reasoner ran: {report.note}"
    else:
        yield f"reasoner: {report.reasoner} ({report.note}), {report.seconds:.1f} s"


def _as_json(report: CheckReport) -> dict[str, Any]:
    found = {field.name: getattr(report, field.name) for field in fields(report)}
    return {
        **found,
        "status": NOT_REACHED if report.errors else REACHED,
        "errors": report.errors,
        "warnings": len(report.findings) - report.errors,
        "seconds": round(report.seconds, 3),
    }


def _compare(file: Path, text: str) -> int:
    lines = read_text(file).splitlines(keepends=True)
    diff = list(difflib.unified_diff(lines, text.splitlines(keepends=True), f"{file}", "as generated"))
    sys.stdout.writelines(diff)
    if diff:
        click.echo(f"{file} is not current", err=True)
    return NOT_REACHED if diff else REACHED
