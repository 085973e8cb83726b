"""The world as a tree: bounded, and nothing is told twice or left out."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from skiros_py.api.world import TreeNode
from skiros_py.errors import UnknownName
from skiros_py.station.world.world import MOST_NODES, tree
from skiros_py.testing import tiny_world

MANY = tiny_world(
    *(f"scene:ball_{n} a tiny:Ball ; sk:in scene:box_{'ab'[n % 2]} ." for n in range(10_000, 10_000 + 2 * MOST_NODES))
)


def nodes(node: TreeNode) -> Iterator[TreeNode]:
    yield node
    for child in node.children:
        yield from nodes(child)


def read_on(root: str, limit: int) -> list[str]:
    found: list[str] = []
    cursor: str | None = ""
    while cursor is not None:
        node = tree(MANY.snapshot(), root, 1, limit, cursor)
        found += [child.id for child in node.children]
        cursor = node.next
    return found


def test_every_tree_node_is_below_its_place_or_its_owner() -> None:
    view = tiny_world().snapshot()
    told = tree(view, "", 20, 1000)

    for node in nodes(told):
        for child in node.children:
            placement = view.placement(child.id)
            assert node.id in ("", *view.owners(child.id), *([placement.place] if placement else ()))
    assert {"box_a", "slot_1", "ball_1"} <= {node.id for node in nodes(told)}


def test_a_tree_is_limited_in_nodes_and_keeps_those_nearest_to_the_root() -> None:
    told = tree(MANY.snapshot(), "", 20, 1000)

    assert len(list(nodes(told))) <= MOST_NODES + 1
    assert told.children_total == len(told.children)


@pytest.mark.parametrize("limit", [1, 7, 1000])
def test_reading_in_pages_gives_each_child_once(limit: int) -> None:
    view = MANY.snapshot()
    root = "slot_1" if limit == 1 else "box_a"
    assert read_on(root, limit) == sorted({*view.contents(root)})


def test_without_depth_children_are_only_counted() -> None:
    told = tree(MANY.snapshot(), "box_a", 0, 10)

    assert (told.children, told.next) == ([], None)
    assert told.children_total > MOST_NODES / 2


def test_an_unknown_root_has_no_tree() -> None:
    with pytest.raises(UnknownName):
        tree(MANY.snapshot(), "nothing", 1, 10)
