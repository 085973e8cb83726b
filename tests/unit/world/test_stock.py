"""Stock: counted things without individuals, and how one of them gets one."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.errors import WorldError
from skiros_py.testing import tiny_ontology, tiny_scene, tiny_world
from skiros_py.world.change import Writer
from skiros_py.world.element import Element, Placement
from skiros_py.world.journal.data_directory import DataDirectory
from skiros_py.world.overlay import Overlay
from skiros_py.world.stock import Stocked, by_stock, is_token, stocks, take
from skiros_py.world.undo import undo
from skiros_py.world.world import World

STOCK = """
scene:box_a sk:hasA scene:reds .
scene:reds a sk:Stock ; sk:stockOf "tiny:RedBall" ; sk:stockCount 2 .
"""


def taken(world: World, token: str = "reds#1") -> str:
    with world.transaction("task", "pick is next") as tx:
        return take(tx, token)


def test_a_stock_has_the_count_and_place_of_its_container() -> None:
    (stock,) = stocks(tiny_world(STOCK))

    assert (stock.id, stock.class_, stock.count) == ("reds", "tiny:RedBall", 2)
    assert stock.placement == Placement("sk:in", "box_a")


def test_a_container_may_hold_several_classes() -> None:
    more = 'scene:box_a sk:hasA scene:giants . scene:giants a sk:Stock ; sk:stockOf "tiny:Giant" ; sk:stockCount 4 .'

    assert {(stock.class_, stock.count) for stock in stocks(tiny_world(STOCK, more))} == {
        ("tiny:RedBall", 2),
        ("tiny:Giant", 4),
    }


@pytest.mark.parametrize(
    "described",
    [
        'scene:box_a sk:hasA scene:reds . scene:reds a sk:Stock ; sk:stockOf "tiny:RedBall" ; sk:stockCount 0 .',
        'scene:box_a sk:hasA scene:reds . scene:reds a sk:Stock ; sk:stockOf "tiny:RedBall" .',
        "scene:box_a sk:hasA scene:reds . scene:reds a sk:Stock ; sk:stockCount 2 .",
        'scene:reds a sk:Stock ; sk:stockOf "tiny:RedBall" ; sk:stockCount 2 .',
    ],
)
def test_a_stock_that_is_used_up_or_badly_described_has_nothing(described: str) -> None:
    assert stocks(tiny_world(described)) == ()


@pytest.mark.parametrize(("property_", "value"), [("sk:stockCount", -1), ("sk:stockOf", "tiny:Unheard")])
def test_a_stock_with_a_negative_count_or_an_unknown_class_is_refused(property_: str, value: str | int) -> None:
    world = tiny_world(STOCK)

    with pytest.raises(WorldError), world.transaction("ann", "wrong") as tx:
        tx.set("reds", property_, value)


def test_taking_from_a_stock_adds_an_element_and_lowers_the_count() -> None:
    world = tiny_world(STOCK)

    name = taken(world)

    assert (name, world.element(name).type) == ("red_ball_2", "tiny:RedBall")
    assert world.placement(name) == Placement("sk:in", "box_a")
    assert world.value("reds", "sk:stockCount") == 1
    assert world.changes[-1].author == "task"


def test_taking_from_an_empty_stock_is_refused_and_changes_nothing() -> None:
    world = tiny_world(STOCK)
    names = {taken(world), taken(world, "reds#2")}
    before = world.version

    with pytest.raises(WorldError, match="nothing is left of stock reds"):
        taken(world)

    assert world.version == before
    assert set(world.instances("tiny:RedBall")) == {"red_ball_1", *names}


def test_a_stock_that_was_removed_gives_nothing() -> None:
    world = tiny_world(STOCK)
    with world.transaction("ann", "away") as tx:
        tx.remove("reds")

    with pytest.raises(WorldError, match="nothing is left of stock reds"):
        taken(world)


def test_undoing_a_take_restores_the_stock_and_the_id_is_never_reused() -> None:
    world = tiny_world(STOCK)
    with world.transaction("ann", "by hand", writer=Writer.PERSON) as tx:
        first = take(tx, "reds#1")

    undo(world, "ann")

    assert not world.has(first)
    assert world.value("reds", "sk:stockCount") == 2
    assert taken(world) != first


def test_a_reopened_world_keeps_its_stock_and_never_reuses_ids(tmp_path: Path) -> None:
    scene = tiny_scene(tmp_path, STOCK)
    with DataDirectory.open(tmp_path / "data", tiny_ontology(), scene=scene) as data:
        first = taken(data.world)

    with DataDirectory.open(tmp_path / "data", tiny_ontology()) as data:
        assert [stock.count for stock in stocks(data.world)] == [1]
        assert data.world.has(first)
        assert taken(data.world) != first


def test_tokens_are_elements_of_a_stocked_world_and_of_no_other() -> None:
    world = tiny_world(STOCK)
    (stock,) = stocks(world)
    view = Stocked(world, {stock: [stock.token(1)]})

    assert view.has("reds#1")
    assert not world.has("reds#1")
    assert view.related("reds#1", "sk:in", "box_a")
    assert view.subjects("sk:in", "box_a") == ("ball_1", "reds#1")
    assert view.objects("reds#1", "sk:in") == ("box_a",)
    assert view.instances("tiny:RedBall") == ("red_ball_1", "reds#1")
    assert view.instances_among("tiny:RedBall", ("reds#1", "ball_1", "red_ball_1")) == ("reds#1", "red_ball_1")
    assert view.placement("reds#1") == Placement("sk:in", "box_a")
    assert view.value("reds#1", "tiny:scanned") is None
    assert view.short


def test_names_for_people_count_tokens_by_stock() -> None:
    assert by_stock(["ball_1", "reds#1", "reds#2"]) == ("ball_1", "2 of stock reds")
    assert [is_token(name) for name in ("reds#1", "reds_1", "learned:mug_1")] == [True, False, False]


@given(st.integers(1, 12), st.integers(0, 8))
def test_pages_of_an_enlarged_world_give_every_instance_once_in_order(page: int, more: int) -> None:
    view = Overlay(tiny_world(*(f"scene:ball_{n} a tiny:Ball ; sk:in scene:box_b ." for n in range(2, 7))))
    for number in range(more):
        view.extend(Element(f"ball_{number}#", "tiny:RedBall", "-"), Placement("sk:in", "box_a"))

    found, last = [], ""
    while some := view.some_instances("tiny:Ball", page, last):
        found += some
        last = some[-1]

    assert tuple(found) == view.instances("tiny:Ball")
    assert len(set(found)) == 7 + more
