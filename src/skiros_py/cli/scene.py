"""``skiros scene``: look at scenes."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from skiros_py.world.tree import TreeNode

__all__ = ["command"]


@click.group("scene")
def command() -> None:
    """Looks at scenes."""


@command.command("list")
def list_scenes() -> int:
    """Lists the scenes that can be given by name."""
    from skiros_py.config import scene_names

    for name in scene_names():
        click.echo(name)
    return 0


@command.command("show", epilog="Example: skiros scene show kitting")
@click.argument("scene")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def show(scene: str, as_json: bool) -> int:
    """Shows SCENE as a tree over what is placed where and what is built of what, and its goal."""
    from skiros_py.runtime import open_world
    from skiros_py.world.tree import tree

    world = open_world(scene)
    roots = tree(world)
    if as_json:
        click.echo(json.dumps({"scene": scene, "goals": list(world.goals), "tree": [_as_json(r) for r in roots]}))
        return 0
    for root in roots:
        _print(root, "")
    for goal in world.goals:
        click.echo(f"goal: {goal}")
    return 0


def _print(node: TreeNode, indent: str) -> None:
    relation = f"{node.relation.partition(':')[2]}: " if node.relation else ""
    click.echo(f"{indent}{relation}{node.element.id} ({node.element.type.partition(':')[2]})")
    for child in node.children:
        _print(child, indent + "  ")


def _as_json(node: TreeNode) -> dict[str, Any]:
    element = node.element
    own = {"id": element.id, "type": element.type, "label": element.label, "relation": node.relation}
    return {**own, "children": [_as_json(child) for child in node.children]}
