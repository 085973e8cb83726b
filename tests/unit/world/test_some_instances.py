"""The first instances of a class, without the others: the same in every form of a world."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.errors import UnknownName
from skiros_py.skills.conditions import Exists, Related
from skiros_py.skills.conditions.watch import ReadingView
from skiros_py.testing import tiny_world
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import NO_SENSORS, WorldView

WORLD = tiny_world(
    *(f"scene:ball_{n} a tiny:{'Red' * (n % 3 == 0)}Ball ; sk:in scene:box_a ." for n in range(100, 180))
)
LEFT_OUT = frozenset({"ball_1", "ball_103", "ball_150"})
VIEWS: tuple[WorldView, ...] = (
    WORLD,
    WORLD.snapshot(),
    Overlay(WORLD),
    Overlay(WORLD, LEFT_OUT),
    ReadingView(WORLD.snapshot(), NO_SENSORS),
)
classes = st.sampled_from(["tiny:Ball", "tiny:RedBall", "tiny:Box", "tiny:Key", "sk:SpatialThing"])


@pytest.mark.parametrize("view", VIEWS, ids=lambda view: type(view).__name__)
@given(class_=classes, limit=st.integers(0, 120), after=st.sampled_from(["", "a", "ball_1", "ball_150", "red", "zz"]))
def test_some_instances_are_the_first_of_all_instances(view: WorldView, class_: str, limit: int, after: str) -> None:
    expected = tuple(name for name in view.instances(class_) if name > after)[:limit]

    assert view.some_instances(class_, limit, after) == expected


@pytest.mark.parametrize("view", VIEWS, ids=lambda view: type(view).__name__)
@given(class_=classes, relation=st.sampled_from(["sk:in", "sk:on", "sk:heldBy", "sk:at"]))
def test_any_placed_tells_what_the_placements_tell(view: WorldView, class_: str, relation: str) -> None:
    placements = map(view.placement, view.instances(class_))

    assert view.any_placed(class_, relation) is any(at is not None and at.relation == relation for at in placements)


@pytest.mark.parametrize("view", VIEWS, ids=lambda view: type(view).__name__)
def test_instances_among_filters_ids_by_class(view: WorldView) -> None:
    ids = ("slot_1", "red_ball_1", "ball_103", "ball_100")

    assert view.instances_among("tiny:Ball", ids) == tuple(i for i in ids if i in view.instances("tiny:Ball"))


def test_an_unknown_class_is_refused_by_name() -> None:
    with pytest.raises(UnknownName, match="tiny:Baal"):
        WORLD.some_instances("tiny:Baal", 1)


@pytest.mark.parametrize(("ball", "there"), [("ball_103", False), ("ball_104", True)])
def test_hidden_elements_are_not_found_through_their_relations(ball: str, there: bool) -> None:
    overlay = Overlay(WORLD)
    overlay.place(ball, "sk:in", "slot_1")
    found = Exists("b", "tiny:Ball", Related("sk:in", "b", "slot")).evaluate(
        Overlay(overlay, LEFT_OUT), {"slot": "slot_1"}
    )

    assert found.holds is there


@given(class_=classes)
def test_the_count_of_instances_equals_the_length_of_their_list(class_: str) -> None:
    index = WORLD.snapshot()

    assert index.count(class_) == len(index.instances(class_))
    assert index.count(class_, abstract=True) == len(index.abstracts(class_))
