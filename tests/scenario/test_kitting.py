"""The main job, in physics, with the camera in the loop."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.physics


def test_three_parts_are_truly_in_their_compartments_at_the_end(open_session):
    session = open_session("kitting", seed=11)

    report = session.run()

    assert [(c.believed, c.true) for c in report.conditions] == [(True, True)] * 3
    assert report.reached


def test_a_kit_carried_by_the_robot_is_filled_without_driving_back(open_session):
    session = open_session("kitting_carried", seed=3)

    report = session.run()

    assert report.reached
    drives = [step.arguments["Location"] for step in report.steps if step.skill == "drive"]
    assert drives == ["pallet_a", "pallet_b"]


def test_a_goal_about_the_robot_is_judged_by_its_true_position(open_session):
    session = open_session("kitting", seed=1)

    report = session.run(["RobotAtLocation(robot_1, pallet_b)"])

    assert report.reached
    assert [step.skill for step in report.steps] == ["drive"]


def test_a_goal_that_already_holds_is_answered_without_moving(open_session):
    session = open_session("kitting", seed=1)

    report = session.run(["ObjectAtLocation(starter_1, pallet_a)"])

    assert report.reached
    assert report.steps == ()
    assert report.simulated == pytest.approx(0.0, abs=0.02)


def test_the_same_seed_gives_the_same_digest_and_another_seed_another(open_session):
    digests = []
    for seed in (5, 5, 6):
        with open_session("kitting_carried", seed=seed) as session:
            digests.append(session.run(["Holding(gripper_1, Starter)"]).digest)

    assert digests[0] == digests[1]
    assert digests[0] != digests[2]


@pytest.mark.parametrize("scene", ["kitting", "kitting_carried"])
def test_only_the_fingers_touch_anything_and_only_their_part(open_session, scene):
    from skiros_py.simulation.truth import Truth

    session = open_session(scene, seed=8)
    truth = Truth(session.simulation)
    session.cycle.observe(truth.watch)

    report = session.run(["InKit(Starter, kit_1)"])

    assert report.reached
    assert set(truth.worst) == {("panda_leftfinger", "starter_1"), ("panda_rightfinger", "starter_1")}
