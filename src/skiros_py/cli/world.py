"""``skiros world``: shows a world, its history, and undoes changes."""

from __future__ import annotations

import json
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skiros_py.cli.commands import Found, reports
from skiros_py.cli.lazy import LazyGroup
from skiros_py.cli.options import AUTHOR, DATA, data_option, key_values, open_existing
from skiros_py.cli.output import REACHED
from skiros_py.cli.server_choice import present_world
from skiros_py.errors import FileError
from skiros_py.station.worlds import open_data, open_world
from skiros_py.world.change import Change, ElementEdit
from skiros_py.world.element import Element
from skiros_py.world.journal.records import Entry
from skiros_py.world.literals import format_value
from skiros_py.world.scene.files import describe, write_atomically
from skiros_py.world.vocabulary import APPLIES_TO, ELEMENT, LEARNED_DURATION

if TYPE_CHECKING:
    from skiros_py.cli.world_open import History, Shown
_MOST_LINES = 20
"""Maximum number of edits shown for one change; a scene has thousands."""

_ELSEWHERE = {
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

    if (data / "journal.db").exists():
        server = find_server(data)
        served = "" if server is None else f", and is served at {server.url}"
        raise FileError(data, f"a world lives here already{served}; 'skiros world show ELEMENT --data …' looks at it")
    with open_data(data, scene) as directory:
        world = directory.world
        click.echo(f"{data}: {len(world.instances(ELEMENT))} elements, {len(world.abstracts(ELEMENT))} abstract ones")
    return REACHED


# ---------------------------------------------------------------- looking


@reports("world show starter_1 --data run/data", command)
@click.argument("element")
@data_option(required=False)
@click.option("--scene", metavar="SCENE", help="A scene, given by name or path, instead.")
def show(element: str, data: Path | None, scene: str | None) -> Found:
    """Shows ELEMENT: class, properties, relations, and the last change."""
    from skiros_py.cli.world_open import OpenWorld

    if (data is None) == (scene is None):
        raise click.UsageError("say where to look: either --data DIR or --scene SCENE")
    if data is None:
        assert scene is not None
        shown = OpenWorld(open_world(scene)).show(element)
    else:
        with present_world(data) as world:
            shown = world.show(element)
    own = ElementEdit(shown.element.id, None, shown.element).as_json()["new"]
    relations = [{"subject": s, "relation": r, "object": o} for s, r, o in shown.statements]
    changed = {"change": shown.stamp.change, "time": shown.stamp.time}
    return {**own, "relations": relations, "changed": changed}, _element_lines(shown)


def _element_lines(shown: Shown) -> Iterator[str]:
    element, stamp = shown.element, shown.stamp
    yield f"{element.id} ({element.type}) '{element.label}'"
    if stamp.change:
        yield f"  changed last by change {stamp.change}, at {stamp.time:.1f} s"
    for property_, value in sorted(element.properties.items()):
        yield f"  {property_} {format_value(value)}"
    yield from (f"  {' '.join(statement)}" for statement in shown.statements)


@reports("world history starter_1 --data run/data --last 10", command)
@click.argument("element", required=False)
@click.option("--all", "everything", is_flag=True, help="Show all changes.")
@click.option("--last", type=click.IntRange(min=1), metavar="N", help="The latest N changes only.")
@DATA
def history(element: str | None, everything: bool, last: int | None, data: Path) -> Found:
    """Shows the changes of ELEMENT, with time, author and reason, oldest first; it may have been removed."""
    if (element is None) != everything:
        raise click.UsageError("say of what: either ELEMENT or --all")
    with present_world(data) as world:
        found = world.history(element, last)
    changes = [{**entry.change.as_json(), "written": _written(entry)} for entry in found.entries]
    return {"remembered_from": found.first, "changes": changes}, _history_lines(found, element)


def _history_lines(found: History, element: str | None) -> Iterator[str]:
    """Yields one line for each change, and one for each of its edits that is about the element."""
    if found.first > 1:
        yield f"changes are remembered from number {found.first} on"
    for entry in found.entries:
        change = entry.change
        yield f"{change.number:6}  {_written(entry)}  {change.author} ({change.writer}): {change.reason}"
        edits = [edit for edit in change.edits if element is None or element in edit.concerns()]
        yield from (f"        {line}" for line in describe(edits[:_MOST_LINES]))
        if len(edits) > _MOST_LINES:
            yield f"        and {len(edits) - _MOST_LINES} more"


def _written(entry: Entry) -> str:
    return datetime.fromtimestamp(entry.wall, UTC).isoformat(timespec="seconds")


# ---------------------------------------------------------------- writing


@reports("world undo --data run/data --author ann", command)
@DATA
@AUTHOR
def undo(data: Path, author: str) -> Found:
    """Undoes the last edit of a person; refused if later changes depend on it."""
    with present_world(data) as world:
        change = world.undo(author)
    return change.as_json(), [f"change {change.number}: {change.reason}"]


@reports("world compact --data run/data --keep 1000", command)
@DATA
@click.option("--keep", type=click.IntRange(min=0), default=1000, show_default=True, help="Number of changes to keep.")
def compact(data: Path, keep: int) -> Found:
    """Deletes all but the latest changes from the journal; older ones are no longer in the history, nor undone."""
    with open_existing(data) as directory:
        directory.compact(keep)
        first, version = directory.journal.first, directory.journal.version
    remembered = f"{version - first + 1} of {version} changes are remembered"
    return {"remembered_from": first, "version": version}, [remembered]


# ---------------------------------------------------------------- learned concepts


@command.group("learned")
def learned() -> None:
    """Lists, adds, edits, deletes, imports or exports the concepts taught to robots."""


@reports("world learned list --data run/data", learned)
@DATA
def list_learned(data: Path) -> Found:
    """Lists the learned concepts."""
    with present_world(data) as world:
        elements = world.learned()
    return {"learned": [ElementEdit(e.id, None, e).as_json()["new"] for e in elements]}, map(_learned_line, elements)


def _learned_line(element: Element) -> str:
    about = f", about {element.properties[APPLIES_TO]}" if APPLIES_TO in element.properties else ""
    return f"{element.id} ({element.type}) '{element.label}'{about}{_rate(element)}"


def _rate(element: Element) -> str:
    """Returns what was learned from runs: how often it succeeds, and how long it takes."""
    if element.type != LEARNED_DURATION:
        return ""
    from skiros_py.planning.experience import estimated, read_tally

    tally = read_tally(element)
    found = estimated((tally,), None)
    time = "" if found is None else f", {found.seconds:.1f} s until it succeeds"
    return f": {tally.successes:.1f} of {tally.successes + tally.failures:.1f} succeed{time}"


_LABEL = click.option("--label", metavar="TEXT", help="Its label.")
_VALUES = click.option(
    "--set",
    "values",
    multiple=True,
    metavar="PROPERTY=VALUE",
    callback=lambda _context, _option, texts: {
        name: _json_or_text(text) for name, text in key_values("--set", texts, "sk:graspWidth=0.05").items()
    },
    help="A value, as JSON or text; null removes it. May be repeated.",
)


def _json_or_text(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return text


@reports("world learned add sk:TaughtGrasp --set sk:appliesTo=kitting:Starter --data run/data", learned)
@click.argument("what", metavar="CLASS")
@click.option("--like", is_flag=True, help="CLASS is an element of the scene, which is copied with its parts.")
@click.option("--id", "id_", metavar="ID", help="Its id, which begins with 'learned:'.  [default: after its class]")
@_LABEL
@_VALUES
@DATA
@AUTHOR
def add(
    what: str, like: bool, id_: str | None, label: str | None, values: dict[str, Any], data: Path, author: str
) -> Found:
    """Adds a learned concept of CLASS; skiros world undo removes it."""
    from skiros_py.api.wire import validated
    from skiros_py.api.world import NewElement

    given = {"like" if like else "class": what, "id": id_, "label": label, "properties": values}
    new = validated(NewElement, {**given, "reason": f"teaches a {what}"})
    with present_world(data) as world:
        return _changed(world.teach(new, author))


@reports("world learned edit learned:mug_1 --set sk:mass=0.3 --data run/data", learned)
@click.argument("concept")
@_LABEL
@_VALUES
@DATA
@AUTHOR
def edit(concept: str, label: str | None, values: dict[str, Any], data: Path, author: str) -> Found:
    """Changes label and values of CONCEPT; skiros world undo restores them."""
    from skiros_py.api.wire import validated
    from skiros_py.api.world import ElementPatch

    patch = validated(ElementPatch, {"label": label, "properties": values, "reason": f"edits {concept}"})
    with present_world(data) as world:
        return _changed(world.edit_learned(concept, patch, author))


@reports("world learned import mugs.ttl --data run/data", learned, name="import")
@click.argument("file", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--replace", is_flag=True, help="Replace concepts that are different here; else they are refused.")
@DATA
@AUTHOR
def import_(file: Path, replace: bool, data: Path, author: str) -> Found:
    """Adds the learned concepts of FILE, which describes nothing else; those that exist already are left.

    It is Turtle, or in another format that its name tells (.nt, .jsonld, .rdf, .owl, .owx).
    """
    with present_world(data) as world:
        return _changed(world.import_learned(file, author, replace=replace))


def _changed(change: Change | None) -> Found:
    if change is None:
        return {"edits": []}, ["nothing to change: it is so already"]
    return change.as_json(), [f"change {change.number}: {change.reason}", *describe(change.edits)]


@reports("world learned forget learned:mug_1 --data run/data", learned)
@click.argument("concept")
@DATA
@AUTHOR
def forget(concept: str, data: Path, author: str) -> Found:
    """Deletes CONCEPT with its parts; skiros world undo restores it."""
    with present_world(data) as world:
        change = world.forget(concept, author)
    return change.as_json(), [f"change {change.number}: {change.reason}"]


@reports("world learned forget-runs --robot robot_1 --data run/data", learned)
@click.option("--skill", default="", metavar="NAME", help="Only what was learned about this skill.")
@click.option("--robot", default="", metavar="ID", help="Only about this robot.")
@click.option("--place", default="", metavar="ID", help="Only about this place.")
@click.option("--type", "kind", default="", metavar="CLASS", help="Only about parts of this class.")
@DATA
@AUTHOR
def forget_runs(data: Path, author: str, **of: str) -> Found:
    """Deletes the durations and success rates learned from runs; skiros world undo restores them."""
    with present_world(data) as world:
        return _changed(world.forget_runs(of, author))


@learned.command("export", epilog="Example: skiros world learned export mugs.ttl --data run/data")
@click.argument("file", required=False, type=click.Path(dir_okay=False, path_type=Path))
@DATA
def export(file: Path | None, data: Path) -> int:
    """Writes the learned concepts as Turtle, to FILE or to stdout.

    A new data directory that contains this file as learned.ttl starts with them.
    """
    with present_world(data) as world:
        text = world.learned_turtle()
    if file is None:
        click.echo(text, nl=False)
    else:
        write_atomically(file, text)
    return REACHED
