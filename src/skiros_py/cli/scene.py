"""``skiros scene``: look at scenes, check, compare and save them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path

import click

from skiros_py.catalogue import load_catalogue
from skiros_py.cli.commands import Found, reports
from skiros_py.cli.options import JSON
from skiros_py.cli.output import DIFFERENT, REACHED, answer_text
from skiros_py.cli.server_choice import present_world
from skiros_py.config import find_scene, named_scene, scene_names
from skiros_py.errors import DescriptionError, FileError, UsageError, escaped
from skiros_py.skills.cell_reader import read_cell
from skiros_py.station.worlds import open_world
from skiros_py.tasks.goals import parse_goal
from skiros_py.world.branches import Branch, tree
from skiros_py.world.scene.files import describe, write_atomically
from skiros_py.world.scene.files import diff as compare
from skiros_py.world.scene.writer import scene_turtle
from skiros_py.world.vocabulary import DEVICE, ELEMENT, ROBOT


@click.group("scene")
def command() -> None:
    """Shows, checks, compares and saves scenes.

    SCENE is a name as `skiros scene list` shows it, or the path of a file that ends in .ttl, .owl, .rdf, .owx,
    .xml, .nt or .jsonld.
    """


@reports("scene list --json", command)
def list_scenes() -> Found:
    """Lists the scenes by name."""
    names = scene_names()
    return {"scenes": {name: str(named_scene(name)) for name in names}}, names


@command.command("show", epilog="Example: skiros scene show kitting")
@click.argument("scene")
@JSON
def show(scene: str, as_json: bool) -> int:
    """Shows SCENE as a tree of placements and parts, and its goal."""
    world = open_world(scene)
    roots = tree(world)
    if as_json:
        head = json.dumps({"scene": scene, "goals": list(world.goals)})
        answer_text("".join((head[:-1], ', "tree": [', *_json_pieces(roots), "]}")))
        return REACHED
    for root in roots:
        for depth, node in root.walk():
            click.echo(escaped("  " * depth + _line(node)))
    for goal in world.goals:
        click.echo(escaped(f"goal: {goal}"))
    return REACHED


@reports("scene check my_cell.ttl", command)
@click.argument("scene")
def check(scene: str) -> Found:
    """Checks SCENE against the ontologies, its goal against the conditions, and whether its cell can be simulated.

    Exit status: 0 nothing is wrong, 2 something is; the message says where and what would be right.
    """
    from skiros_py.simulation.cell import SimulatedCell

    world = open_world(scene)
    try:
        parse_goal(world.goals, world, load_catalogue().conditions)
    except UsageError as error:
        raise FileError(find_scene(scene), f"sk:goal: {error}") from error
    if world.instances(DEVICE):  # else it is a world to be asked, not a cell
        try:
            SimulatedCell(read_cell(world.snapshot(), world.instances(ROBOT)), seed=0).close()
        except DescriptionError as error:
            raise FileError(find_scene(scene), str(error)) from error
    elements = len(world.instances(ELEMENT))
    line = f"{scene}: {elements} elements, {len(world.goals)} goals, nothing wrong"
    return {"scene": scene, "elements": elements, "goals": list(world.goals)}, [line]


@reports("scene diff kitting my_cell.ttl", command)
@click.argument("old")
@click.argument("new")
def diff(old: str, new: str) -> Found:
    """Shows the edits that turn the scene OLD into NEW.

    Exit status: 0 they are equal, 1 they are different, 2 one of them is broken.
    """
    before, after = open_world(old).snapshot(), open_world(new).snapshot()
    edits = compare(before, after)
    found = {"old": old, "new": new, "edits": [edit.as_json() for edit in edits]}
    return found, describe(edits), DIFFERENT if edits else REACHED


@command.command("save", epilog="Examples: skiros scene save kitting copy.ttl; skiros scene save --data DIR now.ttl")
@click.argument("scene_and_file", nargs=-1, required=True, metavar="[SCENE] FILE")
@click.option(
    "--data",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Save the current world of a data directory instead of a scene.",
)
def save(scene_and_file: tuple[str, ...], data: Path | None) -> int:
    """Writes SCENE with all that it imports as one Turtle file FILE, in an order that depends on the content alone."""
    *scenes, file = scene_and_file
    if len(scenes) != (0 if data else 1):
        raise UsageError("with --data give the FILE only" if data else "give SCENE and FILE, or --data DIR and FILE")
    if not file.endswith(".ttl"):
        raise UsageError(f"'{file[:80]}' must end in .ttl: scenes are written as Turtle")
    if data is None:
        text = scene_turtle(open_world(scenes[0]).snapshot())
    else:
        with present_world(data) as world:
            text = world.scene_turtle()
    write_atomically(Path(file), text)
    return REACHED


def _line(node: Branch) -> str:
    relation = f"{node.relation.partition(':')[2]}: " if node.relation else ""
    return f"{relation}{node.element.id} ({node.element.type.partition(':')[2]})"


def _json_pieces(roots: Iterable[Branch]) -> Iterator[str]:
    """Yields the branches as JSON, piece by piece: the encoder dies of what hangs a thousand deep."""
    open_ = 0
    for depth, node in ((depth, node) for root in roots for depth, node in root.walk()):
        yield "]}" * (open_ - depth)
        yield ", " if open_ > depth else ""
        yield f'{_own_json(node)[:-1]}, "children": ['
        open_ = depth + 1
    yield "]}" * open_


def _own_json(node: Branch) -> str:
    element = node.element
    return json.dumps({"id": element.id, "type": element.type, "label": element.label, "relation": node.relation})
