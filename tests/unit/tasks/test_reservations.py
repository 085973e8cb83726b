from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from skiros_py.planning.plan import Step
from skiros_py.tasks.reservations import Reservations, in_hands, robot_of, used_by
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE

SKILLS = {skill.name: skill for skill in (DRIVE, PICK, PLACE)}


def test_who_asks_for_what_is_free_gets_it() -> None:
    reservations = Reservations()
    reservations.request("a", ["robot_1"])
    reservations.request("b", ["robot_2"])

    assert reservations.granted("a", ())
    assert reservations.granted("b", ())
    assert reservations.of_others("a") == {"robot_2"}


def test_who_wants_what_another_has_waits_and_can_say_for_what() -> None:
    reservations = Reservations()
    reservations.request("a", ["robot_1", "ball_1"])
    assert reservations.granted("a", ())
    reservations.request("b", ["robot_1"])

    assert not reservations.granted("b", ())
    assert reservations.waits_for("b") == ("robot_1 (a)",)
    reservations.request("a", ["ball_1"])
    assert reservations.granted("b", ())


def test_who_asked_first_comes_first() -> None:
    reservations = Reservations()
    reservations.request("a", ["r"])
    assert reservations.granted("a", ())
    for who in ("b", "c"):
        reservations.request(who, ["r"])
    reservations.release("a")

    assert not reservations.granted("c", ())
    assert reservations.granted("b", ())


def test_who_wants_more_keeps_meanwhile_only_what_still_moves() -> None:
    reservations = Reservations()
    for who, own in (("a", "r1"), ("b", "r2")):
        reservations.request(who, [own])
        assert reservations.granted(who, ())
    for who in ("a", "b"):
        reservations.request(who, ["r1", "r2"])

    assert not reservations.granted("a", ["r1"])
    assert not reservations.granted("b", ["r2"])
    assert not reservations.granted("a", ())
    assert not reservations.granted("b", ())
    assert reservations.granted("a", ()), "b has let go of what no longer moves"


@given(st.lists(st.tuples(st.sampled_from("abc"), st.sets(st.sampled_from("123"))), max_size=30), st.data())
def test_nothing_is_ever_with_two_tasks_and_nobody_waits_for_ever(
    requests: list[tuple[str, set[str]]], data: st.DataObject
) -> None:
    reservations = Reservations()
    got: dict[str, set[str]] = {}
    for who, wanted in requests:
        reservations.request(who, wanted)
        got[who] = wanted
        if reservations.granted(who, ()):
            others = [got[o] for o in got if o != who and not reservations.waits(o)]
            assert all(wanted.isdisjoint(other) for other in others)
    for _ in range(4):
        for who in list(got):
            if reservations.granted(who, ()):
                reservations.release(who)
                del got[who]
    assert not got


def test_a_plan_uses_its_robots_what_it_moves_and_where_it_puts_it() -> None:
    pick = {"Arm": "arm_1", "Gripper": "gripper_1", "Robot": "robot_1", "Box": "box_a", "Ball": "ball_1"}
    place = {"Arm": "arm_1", "Gripper": "gripper_1", "Robot": "robot_1", "Ball": "ball_1", "Slot": "slot_1"}
    drive = {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"}
    world = tiny_world()

    plan = [Step("drive", drive), Step("pick", pick), Step("place", place)]
    assert used_by(plan, SKILLS, world) == {"robot_1", "ball_1", "slot_1"}


def test_a_subsystem_that_is_gone_stands_for_itself() -> None:
    world = tiny_world()

    assert robot_of(world, "arm_1") == "robot_1"
    assert robot_of(world, "arm_9") == "arm_9"


def test_what_still_moves_when_a_task_is_over_is_free_when_it_stands() -> None:
    reservations, standing = Reservations(), [False]
    reservations.request("a", ["robot_1", "robot_2"])
    assert reservations.granted("a", ())
    reservations.release("a", ["robot_1", "box_a"], lambda: standing[0])

    for who, robot in (("a", "robot_1"), ("b", "robot_2"), ("c", "box_a")):
        reservations.request(who, [robot])
    assert not reservations.granted("a", ()), "another task of that name waits as all others do"
    assert reservations.waits_for("a") == ("robot_1 (a)",)
    assert reservations.granted("b", ())
    assert reservations.granted("c", ()), "that was never reserved"
    assert "robot_1" in reservations.of_others("b")
    standing[0] = True
    assert reservations.granted("a", ())


def test_who_withdraws_stands_in_nobodys_way() -> None:
    reservations = Reservations()
    for who in "abc":
        reservations.request(who, ["robot_1"])
        reservations.granted(who, ())
    reservations.withdraw("b", ())
    reservations.release("a")

    assert reservations.granted("c", ())


def test_what_a_robot_has_in_its_hand_keeps_the_robot() -> None:
    world = tiny_world()
    ids = {"ball_1", "red_ball_1", "slot_1", "robot_1"}

    assert in_hands(world, ids) == set()
    with world.transaction("somebody", "picked") as tx:
        tx.place("ball_1", "sk:heldBy", "gripper_1")
    assert in_hands(world, ids) == {"ball_1", "robot_1"}
