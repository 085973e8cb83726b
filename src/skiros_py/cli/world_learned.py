"""``skiros world learned``: concepts taught to robots."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from skiros_py.cli.commands import Found, reports
from skiros_py.cli.options import AUTHOR, DATA
from skiros_py.cli.output import REACHED
from skiros_py.cli.reaching import present_world
from skiros_py.world.vocabulary import APPLIES_TO

if TYPE_CHECKING:
    from skiros_py.world.element import Element


@click.group("learned")
def command() -> None:
    """Lists, deletes or exports the concepts taught to robots."""


@reports("world learned list --data run/data", command)
@DATA
def list_learned(data: Path) -> Found:
    """Lists the learned concepts."""
    from skiros_py.world.change import ElementEdit

    with present_world(data) as world:
        elements = world.learned()
    return {"learned": [ElementEdit(e.id, None, e).as_json()["new"] for e in elements]}, map(_line, elements)


def _line(element: Element) -> str:
    about = f", about {element.properties[APPLIES_TO]}" if APPLIES_TO in element.properties else ""
    return f"{element.id} ({element.type}) '{element.label}'{about}"


@reports("world learned forget learned:mug_1 --data run/data", command)
@click.argument("concept")
@DATA
@AUTHOR
def forget(concept: str, data: Path, author: str) -> Found:
    """Deletes CONCEPT with its parts; skiros world undo restores it."""
    with present_world(data) as world:
        change = world.forget(concept, author)
    return change.as_json(), [f"change {change.number}: {change.reason}"]


@command.command("export", epilog="Example: skiros world learned export mugs.ttl --data run/data")
@click.argument("file", required=False, type=click.Path(dir_okay=False, path_type=Path))
@DATA
def export(file: Path | None, data: Path) -> int:
    """Writes the learned concepts as Turtle, to FILE or to stdout.

    A new data directory that contains this file as learned.ttl starts with them.
    """
    from skiros_py.world.scene.files import write_atomically

    with present_world(data) as world:
        text = world.learned_turtle()
    if file is None:
        click.echo(text, nl=False)
    else:
        write_atomically(file, text)
    return REACHED
