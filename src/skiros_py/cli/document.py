"""``skiros document``: documents of a server, written, run and debugged."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from skiros_py.cli.module import given_params
from skiros_py.cli.options import JSON
from skiros_py.cli.output import tell
from skiros_py.cli.reaching import with_client
from skiros_py.errors import FileError

if TYPE_CHECKING:
    from skiros_py.api.modules import DocumentInfo, ModuleRunInfo
    from skiros_py.client import Client


@click.group("document")
def command() -> None:
    """Lists, writes, removes, runs and debugs the documents of a server: trees, nets and graphs."""


@command.command("list", epilog="Example: skiros document list tree --data cell")
@click.argument("kind")
@with_client()
@JSON
def list_(kind: str, client: Client, as_json: bool) -> int:
    """Lists the documents of a KIND ("tree")."""
    found = client.documents.list(kind)
    return tell(found, map(_line, found.documents), as_json=as_json)


@command.command("show", epilog="Example: skiros document show tree tidy_up --data cell")
@click.argument("kind")
@click.argument("id_", metavar="ID")
@click.option("--revisions", is_flag=True, help="List the revisions that are kept, the oldest first.")
@with_client()
@JSON
def show(kind: str, id_: str, revisions: bool, client: Client, as_json: bool) -> int:
    """Shows a document as it is now, or its revisions."""
    if revisions:
        found = client.documents.revisions(kind, id_)
        return tell(found, map(_line, found.documents), as_json=as_json)
    document = client.documents.get(kind, id_)
    return tell(document, [json.dumps(document.data, indent=2, ensure_ascii=False)], as_json=as_json)


@command.command("write", epilog="Example: skiros document write tree tidy_up tidy_up.json --data cell")
@click.argument("kind")
@click.argument("id_", metavar="ID")
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False, exists=True))
@with_client()
@JSON
def write(kind: str, id_: str, file: Path, client: Client, as_json: bool) -> int:
    """Writes a document from a JSON FILE, new or as a further revision; its next run is of this one."""
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
    except ValueError as error:
        raise FileError(file, f"it is no JSON: {error}") from error
    known = {document.id: document.revision for document in client.documents.list(kind).documents}
    document = client.documents.put(kind, id_, data, seen=known.get(id_))
    return tell(document, [_line(document)], as_json=as_json)


@command.command("remove", epilog="Example: skiros document remove tree tidy_up --data cell")
@click.argument("kind")
@click.argument("id_", metavar="ID")
@with_client()
@JSON
def remove(kind: str, id_: str, client: Client, as_json: bool) -> int:
    """Removes a document; what runs of it goes on."""
    client.documents.remove(kind, id_, seen=client.documents.get(kind, id_).revision)
    return tell({"removed": f"{kind}:{id_}"}, [f"{kind}:{id_} is removed"], as_json=as_json)


@command.command("run", epilog="Example: skiros document run tree tidy_up --agent arm_1 --break body/1 --data cell")
@click.argument("kind")
@click.argument("id_", metavar="ID")
@click.option("--agent", required=True, metavar="ID", help="Subsystem whose skill manager runs it.")
@click.option("--param", "params", multiple=True, metavar="KEY=VALUE", help="A parameter. Repeat it.")
@click.option("--break", "paths", multiple=True, metavar="PATH", help="Pause before this node. Repeat it.")
@with_client()
@JSON
def run(
    kind: str,
    id_: str,
    agent: str,
    params: tuple[str, ...],
    paths: tuple[str, ...],
    client: Client,
    as_json: bool,
) -> int:
    """Starts a document and says how its run is called."""
    started = client.modules.run(agent, f"{kind}:{id_}", given_params(params), breakpoints=paths)
    return tell(started, _run_lines(started), as_json=as_json)


@command.command("break", epilog="Example: skiros document break 3f2a9c1e-1 body/1 --data cell")
@click.argument("run")
@click.argument("paths", nargs=-1, metavar="[PATH]...")
@with_client()
@JSON
def break_(run: str, paths: tuple[str, ...], client: Client, as_json: bool) -> int:
    """Pauses a RUN before these nodes and no others; without a PATH before none."""
    found = client.modules.set_breakpoints(run, paths)
    return tell(found, _run_lines(found), as_json=as_json)


@command.command("command", epilog="Example: skiros document command 3f2a9c1e-1 resume --data cell")
@click.argument("run")
@click.argument("verb", type=click.Choice(["pause", "resume", "step", "stop"]))
@with_client()
@JSON
def command_run(run: str, verb: Literal["pause", "resume", "step", "stop"], client: Client, as_json: bool) -> int:
    """Pauses a RUN, resumes it, lets it do one cycle while it is paused, or stops it."""
    found = client.modules.command(run, verb)
    return tell(found, _run_lines(found), as_json=as_json)


def _line(document: DocumentInfo) -> str:
    return f"{document.module} revision {document.revision}"


def _run_lines(run: ModuleRunInfo) -> list[str]:
    return [f"{run.module} runs as {run.id}: {run.status}", *(f"  pauses before {path}" for path in run.breakpoints)]
