"""``skiros world``: shows a world, its history, and undoes changes."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import click

from skiros_py.cli.lazy import LazyGroup
from skiros_py.cli.options import AUTHOR, DATA, JSON, data_option, open_existing
from skiros_py.cli.output import REACHED, answer, escaped, tell
from skiros_py.cli.reaching import present_world
from skiros_py.errors import FileError
from skiros_py.world.vocabulary import ELEMENT

if TYPE_CHECKING:
    from skiros_py.cli.world_open import History, Shown
    from skiros_py.world.journal import Entry
    from skiros_py.world.ontology import Ontology

_MOST_LINES = 20
"""Maximum number of edits shown for one change; a scene has thousands."""

_ELSEWHERE = {
    "learned": ("world_learned", "Lists, deletes or exports the concepts taught to robots."),
    "query": ("world_query", "Runs a SPARQL query."),
}
"""Commands in other modules, imported when used."""


@click.group("world", cls=LazyGroup, elsewhere=_ELSEWHERE)
def command() -> None:
    """Shows the world of a data directory, and undoes changes.

    If a server runs on the directory, its current world is used.
    """


# ---------------------------------------------------------------- beginning


@command.command("create", epilog="Example: skiros world create kitting --data run/data")
@click.argument("scene")
@DATA
def create(scene: str, data: Path) -> int:
    """Creates a data directory whose world begins with SCENE, given by name or path.

    An existing learned.ttl in it is read, too.
    """
    from skiros_py.client.client import find_server
    from skiros_py.station.worlds import open_data

    if (data / "journal.db").exists():
        server = find_server(data)
        served = "" if server is None else f", and is served at {server.url}"
        raise FileError(data, f"a world lives here already{served}; 'skiros world show ELEMENT --data …' looks at it")
    with open_data(data, scene) as directory:
        world = directory.world
        click.echo(f"{data}: {len(world.instances(ELEMENT))} elements, {len(world.abstracts(ELEMENT))} abstract ones")
    return REACHED


# ---------------------------------------------------------------- looking


@command.command("show", epilog="Example: skiros world show starter_1 --data run/data")
@click.argument("element")
@data_option(required=False)
@click.option("--scene", metavar="SCENE", help="A scene, given by name or path, instead.")
@JSON
def show(element: str, data: Path | None, scene: str | None, as_json: bool) -> int:
    """Shows ELEMENT: class, properties, relations, and the last change."""
    from skiros_py.cli.world_open import OpenWorld
    from skiros_py.station.worlds import open_world

    if (data is None) == (scene is None):
        raise click.UsageError("say where to look: either --data DIR or --scene SCENE")
    if data is None:
        assert scene is not None
        shown = OpenWorld(open_world(scene)).show(element)
    else:
        with present_world(data) as world:
            shown = world.show(element)
    _show(shown, as_json=as_json)
    return REACHED


def _show(shown: Shown, *, as_json: bool) -> None:
    from skiros_py.world.change import ElementEdit
    from skiros_py.world.literals import ANY_LITERAL, format_value

    element, stamp, statements = shown.element, shown.stamp, shown.statements
    if as_json:
        own = ElementEdit(element.id, None, element).as_json()["new"]
        relations = [{"subject": s, "relation": r, "object": o} for s, r, o in statements]
        answer({**own, "relations": relations, "changed": {"change": stamp.change, "time": stamp.time}})
        return
    click.echo(escaped(f"{element.id} ({element.type}) '{element.label}'"))
    if stamp.change:
        click.echo(f"  changed last by change {stamp.change}, at {stamp.time:.1f} s")
    for property_, value in sorted(element.properties.items()):
        click.echo(escaped(f"  {property_} {format_value(value, ANY_LITERAL)}"))
    for subject, relation, object_ in statements:
        click.echo(escaped(f"  {subject} {relation} {object_}"))


@command.command("history", epilog="Example: skiros world history starter_1 --data run/data --last 10")
@click.argument("element", required=False)
@click.option("--all", "everything", is_flag=True, help="Show all changes.")
@click.option("--last", type=click.IntRange(min=1), metavar="N", help="The latest N changes only.")
@DATA
@JSON
def history(element: str | None, everything: bool, last: int | None, data: Path, as_json: bool) -> int:
    """Shows the changes of ELEMENT, with time, author and reason, oldest first; it may have been removed."""
    if (element is None) != everything:
        raise click.UsageError("say of what: either ELEMENT or --all")
    with present_world(data) as world:
        found = world.history(element, last)
        if not as_json:
            _print_history(found, element, world.ontology())
            return REACHED
    changes = [{**entry.change.as_json(), "written": _written(entry)} for entry in found.entries]
    answer({"remembered_from": found.first, "changes": changes})
    return REACHED


def _print_history(found: History, element: str | None, ontology: Ontology) -> None:
    if found.first > 1:
        click.echo(f"changes are remembered from number {found.first} on")
    for entry in found.entries:
        _print_change(ontology, entry, element)


def _print_change(ontology: Ontology, entry: Entry, element: str | None) -> None:
    """One line for the change, and one for each of its edits that is about the element."""
    from skiros_py.world.scene.files import describe

    change = entry.change
    click.echo(escaped(f"{change.number:6}  {_written(entry)}  {change.author} ({change.writer}): {change.reason}"))
    edits = [edit for edit in change.edits if element is None or element in edit.concerns()]
    for line in list(describe(ontology, edits[:_MOST_LINES])):
        click.echo(escaped(f"        {line}"))
    if len(edits) > _MOST_LINES:
        click.echo(f"        and {len(edits) - _MOST_LINES} more")


def _written(entry: Entry) -> str:
    return datetime.fromtimestamp(entry.wall, UTC).isoformat(timespec="seconds")


# ---------------------------------------------------------------- writing


@command.command("undo", epilog="Example: skiros world undo --data run/data --author ann")
@DATA
@AUTHOR
@JSON
def undo(data: Path, author: str, as_json: bool) -> int:
    """Undoes the last edit of a person; refused if later changes depend on it."""
    with present_world(data) as world:
        change = world.undo(author)
    return tell(change.as_json(), [f"change {change.number}: {change.reason}"], as_json=as_json)


@command.command("compact", epilog="Example: skiros world compact --data run/data --keep 1000")
@DATA
@click.option("--keep", type=click.IntRange(min=0), default=1000, show_default=True, help="Number of changes to keep.")
@JSON
def compact(data: Path, keep: int, as_json: bool) -> int:
    """Deletes all but the latest changes from the journal; older ones are no longer in the history, nor undone."""
    with open_existing(data) as directory:
        directory.compact(keep)
        first, version = directory.journal.first, directory.journal.version
    remembered = [f"{version - first + 1} of {version} changes are remembered"]
    return tell({"remembered_from": first, "version": version}, remembered, as_json=as_json)
