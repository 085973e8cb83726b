"""``skiros document``: documents of a server: imported, exported, run and debugged."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from skiros_py.cli.commands import Found, served
from skiros_py.cli.options import combined, given_params
from skiros_py.errors import UnknownName
from skiros_py.files import read_text

if TYPE_CHECKING:
    from skiros_py.api.documents import DocumentInfo
    from skiros_py.api.modules import ModuleRunInfo, RunCommand
    from skiros_py.client import Client


_DOCUMENT = combined(click.argument("kind"), click.argument("id_", metavar="ID"))


@click.group("document")
def command() -> None:
    """Lists, imports, exports, removes, runs and debugs the documents of a server: trees, sequences, goal templates."""


@served("document list tree --data cell", command)
@click.argument("kind")
def list_(client: Client, kind: str) -> Found:
    """Lists the documents of a KIND ("tree")."""
    found = client.documents.list(kind)
    return found, map(_line, found.items)


@served("document show tree tidy_up --data cell", command)
@_DOCUMENT
@click.option("--revisions", is_flag=True, help="List the stored revisions, oldest first.")
def show(client: Client, kind: str, id_: str, revisions: bool) -> Found:
    """Shows the latest revision of a document, or lists its revisions."""
    if revisions:
        found = client.documents.revisions(kind, id_)
        return found, map(_line, found.items)
    document = client.documents.get(kind, id_)
    return document, [json.dumps(document.data, indent=2, ensure_ascii=False), *_problems(document)]


@served("document import tree tidy_up tidy_up.json --data cell", command)
@_DOCUMENT
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False, exists=True))
@click.option("--format", "format_", metavar="NAME", help="One of the formats of KIND.  [default: the first one]")
def import_(client: Client, kind: str, id_: str, file: Path, format_: str | None) -> Found:
    """Writes a document or a new revision of it from a FILE; its next run uses it."""
    formats = {one.kind: one.formats for one in client.documents.kinds().items}.get(kind, {"json": "application/json"})
    if format_ is not None and format_ not in formats:
        raise UnknownName("format", format_, formats, where=f"of {kind} documents")
    media_type = next(iter(formats.values())) if format_ is None else formats[format_]
    known = {document.id: document.revision for document in client.documents.list(kind).items}
    document = client.documents.import_text(kind, id_, read_text(file), media_type, seen=known.get(id_))
    return document, [_line(document), *_problems(document)]


@served("document export tree tidy_up --data cell", command)
@_DOCUMENT
@click.option("--format", "format_", metavar="NAME", help="One of the formats of KIND.  [default: the first one]")
def export(client: Client, kind: str, id_: str, format_: str | None) -> Found:
    """Prints a document as text in a format of its KIND."""
    text = client.documents.export(kind, id_, format_)
    return {"text": text}, text.splitlines()


@served("document remove tree tidy_up --data cell", command)
@_DOCUMENT
def remove(client: Client, kind: str, id_: str) -> Found:
    """Deletes a document; active runs continue."""
    client.documents.remove(kind, id_, seen=client.documents.get(kind, id_).revision)
    return {"removed": f"{kind}:{id_}"}, [f"{kind}:{id_} is removed"]


@served("document run tree tidy_up --agent arm_1 --break body/1 --data cell", command)
@_DOCUMENT
@click.option("--agent", required=True, metavar="ID", help="Subsystem whose skill manager runs it.")
@click.option("--param", "params", multiple=True, metavar="KEY=VALUE", help="A parameter; may be repeated.")
@click.option("--break", "paths", multiple=True, metavar="PATH", help="Pause before this node; may be repeated.")
def run(
    client: Client,
    kind: str,
    id_: str,
    agent: str,
    params: tuple[str, ...],
    paths: tuple[str, ...],
) -> Found:
    """Starts a document and prints the id of its run."""
    started = client.modules.run(agent, f"{kind}:{id_}", given_params(params), breakpoints=paths)
    return started, _run_lines(started)


@served("document break 3f2a9c1e-1 body/1 --data cell", command)
@click.argument("run")
@click.argument("paths", nargs=-1, metavar="[PATH]...")
def break_(client: Client, run: str, paths: tuple[str, ...]) -> Found:
    """Sets the breakpoints of a RUN to these nodes; without a PATH, removes them."""
    found = client.modules.set_breakpoints(run, paths)
    return found, _run_lines(found)


@served("document command 3f2a9c1e-1 resume --data cell", command)
@click.argument("run")
@click.argument("verb", type=click.Choice(["pause", "resume", "step", "stop"]))
def command_run(client: Client, run: str, verb: RunCommand) -> Found:
    """Pauses, resumes or stops a RUN, or executes one cycle of a paused one."""
    found = client.modules.command(run, verb)
    return found, _run_lines(found)


def _problems(document: DocumentInfo) -> list[str]:
    return [f"would not work now: {one.place}: {one.text}" for one in document.problems]


def _line(document: DocumentInfo) -> str:
    return f"{document.module} revision {document.revision}"


def _run_lines(run: ModuleRunInfo) -> list[str]:
    return [f"{run.module} runs as {run.id}: {run.status}", *(f"  pauses before {path}" for path in run.breakpoints)]
