from __future__ import annotations

import pytest
from support.planning import tiny_task

from skiros_py.errors import WorldError
from skiros_py.planning.edits import Add, Assign, HypotheticalView, Move, Relate, Remove, SceneEdit
from skiros_py.planning.explanation.explaining import explain
from skiros_py.planning.plan import NoPlan, Repair
from skiros_py.skills.conditions import Condition
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, IN_CONTAINER
from skiros_py.world.element import Placement
from skiros_py.world.view import WorldView
from skiros_py.world.world import World


def explained(world: World, *goal: Condition, works: bool | None = True) -> NoPlan:
    return explain(tiny_task(world, *goal), lambda _view, _goal: answering(works))


def answering(works: bool | None) -> bool | None:
    return works


def full() -> World:
    return tiny_world("scene:ball_9 a tiny:Ball ; sk:in scene:slot_1 .")


def test_the_smallest_change_is_offered_first() -> None:
    found = explained(full(), IN_CONTAINER("ball_1", "slot_1"), AT_LOCATION("robot_1", "box_a"))

    assert [repair.text for repair in found.repairs] == [
        "want In(ball_1, slot_2) instead of In(ball_1, slot_1)",
        "put ball_9 in box_a",
        "remove ball_9 from the scene",
        "give up In(ball_1, slot_1)",
    ]


@pytest.mark.parametrize("answer", [False, None])
def test_repairs_that_are_not_known_to_work_are_not_offered(answer: bool | None) -> None:
    assert explained(full(), IN_CONTAINER("ball_1", "slot_1"), works=answer).repairs == ()


def test_giving_up_the_only_condition_is_never_offered() -> None:
    found = explained(full(), IN_CONTAINER("ball_1", "slot_1"))

    assert found.repairs
    assert not any(repair.without for repair in found.repairs)


def test_one_repair_covers_several_causes() -> None:
    stray = [f"scene:ball_{n} a tiny:Ball ; sk:in scene:slot_{n - 7} ." for n in (8, 9)]

    found = explained(tiny_world(*stray), IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("red_ball_1", "slot_2"))

    assert found.repairs[0].text == "put ball_8 in box_a and put ball_9 in box_a"


def test_a_goal_without_a_capable_robot_is_explained_in_words() -> None:
    world = tiny_world()
    task = tiny_task(world, AT_LOCATION("robot_1", "box_a"), agents=("arm_1",))

    found = explain(task, lambda _view, _goal: answering(True))

    assert found.repairs == (Repair("give base_1 the skill 'drive', or start a robot that has it"),)


def test_a_repair_is_one_transaction_with_author_and_reason() -> None:
    world = full()
    repair = Repair("clear the slot", (Move("ball_9", "sk:in", "box_a"), Move("ball_1", "sk:in", "box_b")))

    repair.apply(world, author="anna")

    change = world.changes[-1]
    assert (change.author, change.reason) == ("anna", "so that there is a plan: clear the slot")
    assert len(change.edits) == 2


def test_the_text_of_an_applied_repair_omits_goal_changes() -> None:
    more = Add("tiny:Ball", Placement("sk:in", "box_b"))
    edits = more, more, Move("ball_9", "sk:in", "box_a")
    repair = Repair("all of it", edits, without=(IN_CONTAINER("ball_1", "slot_1"),))

    assert repair.done == "bring one more Ball, in box_b and put ball_9 in box_a"
    assert Repair("see to it").done == ""


def test_an_outdated_repair_changes_nothing() -> None:
    world = full()
    repair = Repair("impossible", (Move("ball_1", "sk:in", "box_b"), Remove("ball_77")))

    with pytest.raises(WorldError, match="ball_77"):
        repair.apply(world)

    assert world.related("ball_1", "sk:in", "box_a")


@pytest.mark.parametrize("edit", [Move("reds#2", "sk:in", "slot_1"), Assign("reds#2", "tiny:scanned", True)])
def test_a_repair_of_a_stock_item_makes_it_an_element_and_reduces_the_stock(
    edit: SceneEdit,
) -> None:
    stock = 'scene:box_a sk:hasA scene:reds . scene:reds a sk:Stock ; sk:stockOf "tiny:RedBall" ; sk:stockCount 2 .'
    world = tiny_world(stock)

    Repair("one of them", (edit,)).apply(world)

    assert world.value("reds", "sk:stockCount") == 1
    assert world.related("red_ball_2", "sk:in", "slot_1") or world.value("red_ball_2", "tiny:scanned") is True


@pytest.mark.parametrize(
    ("edit", "text"),
    [
        (Move("ball_1", "sk:in", "slot_2"), "put ball_1 in slot_2"),
        (Remove("ball_1"), "remove ball_1 from the scene"),
        (Add("tiny:RedBall", Placement("sk:in", "box_a")), "bring one more RedBall, in box_a"),
        (Assign("ball_1", "tiny:scanned", True), "see to it that the scanned of ball_1 is true, and say so"),
        (Assign("box_a", "sk:mass", 1.0, "box_b"), "give box_a the mass of box_b"),
        (Relate("robot_1", "tiny:knows", "box_a"), "state that robot_1 knows box_a"),
    ],
)
def test_a_repair_writes_exactly_what_was_assumed(edit: SceneEdit, text: str) -> None:
    world = tiny_world()
    supposed = HypotheticalView(world)

    edit.write(supposed)
    imagined = facts(supposed)
    Repair(text, (edit,)).apply(world)

    assert str(edit) == text
    assert imagined == facts(world)


def facts(view: WorldView) -> object:
    balls = view.instances("tiny:Ball")
    places = sorted((view.element(b).type, str(view.placement(b))) for b in balls)
    scanned = [view.value("ball_1", "tiny:scanned")] if view.has("ball_1") else []
    return places, scanned, view.value("box_a", "sk:mass"), view.objects("robot_1", "tiny:knows")
