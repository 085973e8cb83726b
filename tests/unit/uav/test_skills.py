"""Skills by air are those of any robot with more conditions; what cannot be done is refused by the plan."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from skiros_py.station.session import Options, Session
from skiros_skills.drive import DRIVE
from skiros_skills.pick import PICK
from skiros_skills.place import PLACE
from skiros_uav.skills import DRIVE_BY_AIR, PICK_BY_AIR, PLACE_BY_AIR

GOAL = "ObjectAtLocation(Starter, kit_1_a)"


@pytest.fixture
def session() -> Iterator[Session]:
    with Session("delivery_uav", Options(fake=True)) as session:
        yield session


def test_descriptions_by_air_add_flight_and_charge_and_keep_the_rest() -> None:
    for own, of_any in ((DRIVE_BY_AIR, DRIVE), (PICK_BY_AIR, PICK), (PLACE_BY_AIR, PLACE)):
        description = own.description
        added = [str(one) for one in description.pre if one not in of_any.description.pre]

        assert added[:2] == ["not Landed(Robot)", "not LowBattery(Robot)"]
        assert set(of_any.description.pre) <= set(description.pre)
        assert description.post == of_any.description.post
        assert description.refines == of_any.description.name
        assert [one.key for one in description.params] == [one.key for one in of_any.description.params]


def test_a_robot_that_flies_has_them_instead_of_those_of_other_robots(session: Session) -> None:
    with Session("kitting", Options(fake=True)) as other:
        on_wheels = {agent: set(manager.skills) for agent, manager in other.managers.items()}
    by_air = {agent: set(manager.skills) for agent, manager in session.managers.items()}

    assert by_air == {
        "base_1": {"charge", "drive_by_air", "fly_to_altitude", "land"},
        "arm_1": {"hand_over_by_air", "pick_by_air", "place_by_air", "search_by_air"},
    }
    assert on_wheels == {"base_1": {"drive"}, "arm_1": {"hand_over", "pick", "place", "search"}}


def test_where_a_skill_by_air_does_not_load_there_is_no_skill_for_the_ground_in_its_place(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("skiros_uav.skills.DRIVE_BY_AIR_FAKE", "no skill")

    with Session("delivery_uav", Options(fake=True)) as session:
        assert set(session.managers["base_1"].skills) == {"charge", "fly_to_altitude", "land"}
        report = session.run()

    assert not report.reached
    assert report.steps == ()
    assert "drive_by_air_fake" in "; ".join(report.no_plan)
    assert "drive_by_air_fake" in caplog.text


def test_what_has_no_aerial_base_cannot_fly() -> None:
    with Session("kitting", Options(fake=True)) as session:
        report = session.run(["Fly(robot_1)"])

    assert report.steps == ()
    assert report.no_plan == ("Fly(robot_1) cannot be reached: robot_1 has no landed, and no skill changes it",)


def test_a_delivery_takes_off_flies_picks_flies_and_places(session: Session) -> None:
    report = session.run()

    assert report.reached
    skills = [step.skill for step in report.steps]
    assert skills == ["fly_to_altitude", "drive_by_air", "pick_by_air", "drive_by_air", "place_by_air"]


def test_with_a_low_battery_it_charges_before_it_takes_off(session: Session) -> None:
    with session.world.transaction("test", "it is low") as tx:
        tx.set("robot_1", "uav:batteryLow", True)

    report = session.run()

    assert report.reached
    assert [step.skill for step in report.steps][:2] == ["charge", "fly_to_altitude"]


def test_it_lands_where_it_is_asked_to(session: Session) -> None:
    report = session.run(["Landed(robot_1)", "RobotAtLocation(robot_1, landing_place_1)"])

    assert report.reached
    assert [step.skill for step in report.steps] == ["fly_to_altitude", "land"]


def test_what_is_too_heavy_is_refused_before_anything_moves(session: Session) -> None:
    with session.world.transaction("test", "it is of lead") as tx:
        tx.set("starter_1", "sk:mass", 2.5)

    report = session.run([GOAL])

    assert not report.reached
    assert report.steps == ()
    assert "2.5 kg" in "; ".join(report.no_plan)
    assert "1 kg at most" in "; ".join(report.no_plan)
