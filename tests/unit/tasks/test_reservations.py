from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from skiros_py.planning.plan import Step
from skiros_py.skills.surroundings import robot_of
from skiros_py.tasks.reservations import Reservations, in_hands, used_by
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE

SKILLS = {skill.name: skill for skill in (DRIVE, PICK, PLACE)}


def test_a_request_for_free_devices_is_granted() -> None:
    reservations = Reservations()

    assert reservations.claim("a", ["robot_1"], ())
    assert reservations.claim("b", ["robot_2"], ())
    assert reservations.of_others("a") == {"robot_2"}


def test_a_request_for_claimed_devices_waits_and_names_them() -> None:
    reservations = Reservations()
    assert reservations.claim("a", ["robot_1", "ball_1"], ())

    assert not reservations.claim("b", ["robot_1"], ())
    assert reservations.waits_for("b") == ("robot_1 (a)",)
    assert reservations.claim("a", ["ball_1"], ())
    assert reservations.claim("b", ["robot_1"], ())


def test_requests_are_served_in_order() -> None:
    reservations = Reservations()
    assert reservations.claim("a", ["r"], ())
    for who in ("b", "c"):
        assert not reservations.claim(who, ["r"], ())
    reservations.release("a")

    assert not reservations.claim("c", ["r"], ())
    assert reservations.claim("b", ["r"], ())


def test_a_task_that_waits_for_more_robots_keeps_only_those_still_moving() -> None:
    reservations = Reservations()
    for who, own in (("a", "r1"), ("b", "r2")):
        assert reservations.claim(who, [own], ())

    both = ["r1", "r2"]
    assert not reservations.claim("a", both, ["r1"])
    assert not reservations.claim("b", both, ["r2"])
    assert not reservations.claim("a", both, ())
    assert not reservations.claim("b", both, ())
    assert reservations.claim("a", both, ()), "b has let go of what no longer moves"


def test_a_task_that_may_start_nothing_takes_nothing_and_keeps_its_place_for_nobody() -> None:
    reservations = Reservations()
    assert reservations.claim("a", ["robot_1"], ())

    assert reservations.claim("a", ["robot_1"], (), starts=False), "it keeps what it has"
    assert not reservations.claim("a", ["robot_1", "robot_2"], ["robot_1"], starts=False)
    assert reservations.claim("b", ["robot_2"], ())


@given(st.lists(st.tuples(st.sampled_from("abc"), st.sets(st.sampled_from("123"))), max_size=30))
def test_no_robot_is_reserved_twice_and_no_task_waits_forever(requests: list[tuple[str, set[str]]]) -> None:
    reservations = Reservations()
    got: dict[str, set[str]] = {}
    waiting: dict[str, set[str]] = {}
    for who, wanted in requests:
        got.pop(who, None)
        waiting.pop(who, None)
        if reservations.claim(who, wanted, ()):
            got[who] = wanted
            assert all(wanted.isdisjoint(other) for name, other in got.items() if name != who)
        else:
            waiting[who] = wanted
    left = {**waiting, **got}
    for _ in range(4):
        for who in list(left):
            if reservations.claim(who, left[who], ()):
                reservations.release(who)
                del left[who]
    assert not left


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
    assert reservations.claim("a", ["robot_1", "robot_2"], ())
    reservations.release("a", ["robot_1", "box_a"], lambda: standing[0])

    assert not reservations.claim("a", ["robot_1"], ()), "another task of that name waits as all others do"
    assert reservations.waits_for("a") == ("robot_1 (a)",)
    assert reservations.claim("b", ["robot_2"], ())
    assert reservations.claim("c", ["box_a"], ()), "that was never reserved"
    assert "robot_1" in reservations.of_others("b")
    standing[0] = True
    assert reservations.claim("a", ["robot_1"], ())


def test_a_task_that_pauses_while_it_waits_does_not_block_others() -> None:
    reservations = Reservations()
    for who in "abc":
        reservations.claim(who, ["robot_1"], ())
    assert not reservations.claim("b", ["robot_1"], (), starts=False)
    reservations.release("a")

    assert reservations.claim("c", ["robot_1"], ())


def test_what_a_robot_has_in_its_hand_keeps_the_robot() -> None:
    world = tiny_world()
    ids = {"ball_1", "red_ball_1", "slot_1", "robot_1"}

    assert in_hands(world, ids) == set()
    with world.transaction("somebody", "picked") as tx:
        tx.place("ball_1", "sk:heldBy", "gripper_1")
    assert in_hands(world, ids) == {"ball_1", "robot_1"}
