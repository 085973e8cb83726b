from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_primitives import locate
from skiros_py.geometry import Pose
from skiros_py.ports.perception import Detection
from skiros_py.testing import Bench, tiny_world

TYPES = ("tiny:Ball", "tiny:RedBall")


def ball(name: str, x: float | None = None, *, type_: str = "tiny:Ball", place: str = "box_a") -> str:
    pose = f' ; sk:pose "{x} 0 0.5 0 0 0"^^sk:poseLiteral' if x is not None else ""
    return f"scene:{name} a {type_} ; sk:in scene:{place}{pose} ."


def at(x: float, type_: str | None = "tiny:Ball") -> Detection:
    return Detection(type_, Pose.of(x, 0.0, 0.5), 0.001, 0.01, (0.05, 0.05, 0.05))


@contextmanager
def bench(*facts: str) -> Iterator[Bench]:
    """The tiny world with further balls; ball_1 (in box_a) and red_ball_1 (in box_b) are out of the way."""
    world = tiny_world(*facts)
    with world.transaction("test", "out of the way") as tx:
        for element in ("ball_1", "red_ball_1"):
            tx.place(element, "sk:on", "floor")
    with Bench(world) as made:
        yield made


def look(*facts: str, sees: Sequence[Detection], types: Sequence[str] = TYPES) -> locate.Association:
    with bench(*facts) as made:
        return locate.associate(made.context, "box_a", types, sees)


def names(found: locate.Association) -> list[str | None]:
    return [element for element, _, _ in found.seen]


def test_a_part_seen_where_it_is_believed_is_that_part() -> None:
    found = look(ball("b", 1.0), sees=[at(1.02)])

    assert found.seen == (("b", "tiny:Ball", at(1.02).pose),)
    assert found.unseen == ()


def test_each_detection_is_the_part_believed_nearest() -> None:
    assert names(look(ball("a", 1.0), ball("b", 1.06), sees=[at(1.07), at(1.01)])) == ["b", "a"]


def test_the_nearest_pair_is_made_first_and_the_other_takes_what_is_left() -> None:
    assert names(look(ball("a", 1.0), ball("b", 1.05), sees=[at(1.06), at(1.045)])) == ["a", "b"]


def test_parts_of_another_type_are_never_taken_for_it() -> None:
    found = look(ball("r", 1.0, type_="tiny:RedBall"), ball("b", 1.5), sees=[at(1.0)])

    assert names(found) == ["b"]
    assert found.unseen == ("r",)


def test_parts_of_another_place_are_never_taken_for_it() -> None:
    found = look(ball("b", 1.0, place="box_b"), sees=[at(1.0)])

    assert names(found) == [None]
    assert found.unseen == ()


def test_an_unseen_part_may_match_any_remaining_detection() -> None:
    assert names(look(ball("known", 1.0), ball("unobserved"), sees=[at(2.0), at(1.0)])) == ["unobserved", "known"]


def test_never_seen_parts_are_matched_before_parts_believed_elsewhere() -> None:
    found = look(ball("a_far", 3.0), ball("unobserved"), sees=[at(1.0)])

    assert names(found) == ["unobserved"]
    assert found.unseen == ("a_far",)


def test_a_part_moved_within_its_place_keeps_its_identity() -> None:
    assert names(look(ball("b", 1.0), sees=[at(1.5)])) == ["b"]


def test_never_seen_parts_are_matched_in_order_of_their_ids() -> None:
    assert names(look(ball("b2"), ball("b1"), sees=[at(1.0), at(2.0)])) == ["b1", "b2"]


def test_a_surplus_detection_is_a_new_part() -> None:
    assert names(look(ball("b", 1.0), sees=[at(1.0), at(1.3)])) == ["b", None]


def test_a_part_believed_there_but_not_detected_is_unseen() -> None:
    assert look(ball("b", 1.0), ball("c"), sees=[]).unseen == ("b", "c")


def test_only_distinguishable_types_are_reported_unseen() -> None:
    assert look(ball("r", type_="tiny:RedBall"), ball("b"), sees=[], types=("tiny:Ball",)).unseen == ("b",)


def test_a_detection_of_unknown_shape_matches_no_part() -> None:
    found = look(ball("b", 1.0), sees=[at(1.0, None)])

    assert found.seen == ()
    assert found.unseen == ("b",)


FACTS = (
    ball("a", 1.0),
    ball("b", 1.1),
    ball("c"),
    ball("r", 1.2, type_="tiny:RedBall"),
    ball("s", type_="tiny:RedBall"),
)
detections = st.lists(st.builds(at, st.floats(0.9, 1.4), st.sampled_from([*TYPES, "tiny:Giant", None])), max_size=6)


@settings(max_examples=60, deadline=None)
@given(detections)
def test_each_part_is_matched_at_most_once_and_only_with_its_own_type(sees: list[Detection]) -> None:
    with bench(*FACTS) as made:
        found = locate.associate(made.context, "box_a", TYPES, sees)
        types = {e: made.world.element(e).type for e in "abcrs"}

    known = [element for element in names(found) if element is not None]
    assert sorted([*known, *found.unseen]) == ["a", "b", "c", "r", "s"]
    assert len(found.seen) == sum(d.type in TYPES for d in sees)
    assert all(types[element] == type_ for element, type_, _ in found.seen if element is not None)
    for type_ in TYPES:
        new = any(element is None and t == type_ for element, t, _ in found.seen)
        assert not (new and any(types[e] == type_ for e in found.unseen)), "nobody is new while one is missing"


STOCK = 'scene:box_a sk:hasA scene:stock . scene:stock a sk:Stock ; sk:stockOf "tiny:Ball" ; sk:stockCount 2 .'
LOST = "scene:lost a tiny:Ball ; sk:on scene:floor ; sk:missing true ."


def test_detected_stock_items_get_no_individuals() -> None:
    assert names(look(STOCK, ball("a", 1.0), sees=[at(2.0), at(1.01), at(3.0)])) == ["a"]


def test_a_part_taken_from_stock_and_not_yet_seen_matches_a_detection() -> None:
    assert names(look(STOCK, ball("a"), sees=[at(1.0), at(2.0), at(3.0)])) == ["a"]


def test_detections_in_excess_of_the_stock_are_new_parts() -> None:
    assert names(look(STOCK, sees=[at(1.0), at(2.0), at(3.0)])) == [None]


def test_detections_explained_by_stock_match_no_missing_part_but_surplus_ones_do() -> None:
    assert names(look(STOCK, LOST, sees=[at(1.0), at(2.0)])) == []
    assert names(look(STOCK, LOST, sees=[at(1.0), at(2.0), at(3.0)])) == ["lost"]


def test_stock_of_one_type_does_not_explain_detections_of_another() -> None:
    assert names(look(STOCK, sees=[at(1.0, "tiny:RedBall")])) == [None]
