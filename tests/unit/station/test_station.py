"""The station in process: a program calls the same use cases as the server."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from skiros_py.api.alarms import AlarmKind
from skiros_py.api.goals import GoalOrder
from skiros_py.api.jobs import JobOrder
from skiros_py.api.world import ElementPatch, NewElement
from skiros_py.errors import NotFound, Refused, StaleVersion, UnknownName, UsageError, WrongState
from skiros_py.station.document_store import DocumentStore
from skiros_py.station.requests import Seen
from skiros_py.station.session import Options, Session
from skiros_py.station.station import Station
from skiros_py.world import vocabulary as v

Opened = Callable[..., Station]


@pytest.fixture
def opened(tmp_path: Path) -> Iterator[Opened]:
    with ExitStack() as stack:

        def open_(scene: str = "kitting", **options: object) -> Station:
            data = tmp_path / "data"
            chosen = Options(fake=True, data=data, **options)  # type: ignore[arg-type]
            return stack.enter_context(Station(lambda: Session(scene, chosen), data))

        yield open_


def test_a_closed_skill_manager_offers_no_skills_until_it_is_reopened(opened: Opened) -> None:
    station = opened()
    offered = {skill.name for skill in station.modules.skills()}

    station.modules.close_manager("base_1")
    without = {skill.name for skill in station.modules.skills()}
    again = station.modules.open_manager("base_1")

    assert offered - without == {"drive"}
    assert "drive" in again.skills
    assert {skill.name for skill in station.modules.skills()} == offered


def test_a_skill_manager_can_be_opened_once_for_each_subsystem_of_the_session_only(opened: Opened) -> None:
    station = opened()

    with pytest.raises(WrongState, match="open already"):
        station.modules.open_manager("base_1")
    with pytest.raises(UsageError, match="belongs to no robot"):
        station.modules.open_manager("starter_1")
    with pytest.raises(NotFound) as unknown:
        station.modules.close_manager("base_9")
    assert unknown.value.code == "UnknownAgent"
    with pytest.raises(NotFound):
        station.modules.open_manager("base_9")


def test_only_the_chosen_skills_are_offered(opened: Opened) -> None:
    station = opened(skills=("drive", "pick"))

    assert {skill.name for skill in station.modules.skills()} == {"drive", "pick"}


def test_a_skill_that_is_not_installed_is_refused_by_name() -> None:
    with pytest.raises(UnknownName, match="unknown skill 'pik'"):
        Session("kitting", Options(fake=True, skills=("pik",)))


def test_a_stored_document_that_cannot_be_read_is_set_aside_with_an_alarm_until_it_is_removed(
    opened: Opened, tmp_path: Path
) -> None:
    (tmp_path / "data").mkdir()
    with closing(DocumentStore(tmp_path / "data" / "server.db")) as store:
        store.put("tree", "bad", {"type": "wait", "seconds": "soon"})
        store.put("tree", "good", {"type": "wait", "seconds": 1})

    station = opened()

    (alarm,) = (alarm for alarm in station.alarms.active if alarm.kind is AlarmKind.MODULE)
    assert (alarm.source, "a number of seconds" in alarm.text) == ("tree:bad", True)
    assert station.session.managers["base_1"].documents == ("tree:good",)
    assert station.documents.get("tree", "bad").data == {"type": "wait", "seconds": "soon"}
    station.documents.remove("tree", "bad")
    assert not [alarm for alarm in station.alarms.active if alarm.kind is AlarmKind.MODULE]


def test_a_camera_that_sees_things_off_is_an_alarm_until_it_sees_well(opened: Opened) -> None:
    station = opened()
    world = station.session.world

    def said_of_cameras() -> list[str]:
        deadline = time.monotonic() + 30.0
        before = [alarm.text for alarm in station.alarms.active if alarm.kind is AlarmKind.CAMERA]
        while (now := [a.text for a in station.alarms.active if a.kind is AlarmKind.CAMERA]) == before:
            assert time.monotonic() < deadline, "the alarms do not change"
            time.sleep(0.02)
        return now

    with world.transaction("test", "compared") as tx:
        tx.set("camera_1", v.SIGHT_ERROR, 0.0145)
    (text,) = said_of_cameras()
    assert str(text) == "camera_1 sees things 14 mm off: compare the cameras, then calibrate it"
    with world.transaction("test", "calibrated") as tx:
        tx.set("camera_1", v.SIGHT_ERROR, None)
    assert said_of_cameras() == []


def test_a_world_without_a_robot_is_edited_and_looked_at(opened: Opened, tmp_path: Path) -> None:
    scene = tmp_path / "empty.ttl"
    with Session("kitting", Options(fake=True)) as session:
        text = _without_robot(session)
    scene.write_text(text)

    station = opened(str(scene))

    assert station.robots.all() == []
    assert station.modules.managers() == []
    assert station.elements.all("kitting:Starter").items
    with pytest.raises(UsageError, match="has no robot"):
        station.session.run("InKit(Starter, kit_1)")


def _without_robot(session: Session) -> str:
    from skiros_py.station.scenes.scenes import scene_only
    from skiros_py.world.scene.writer import scene_turtle

    with session.world.transaction("test", "no robot") as tx:
        for robot in session.world.instances("sk:Robot"):
            tx.remove(robot)
    return scene_turtle(scene_only(session.world.snapshot()))


def test_a_program_orders_a_job_and_reads_its_report(opened: Opened) -> None:
    station = opened()

    result = station.jobs.order(JobOrder(goal=["InKit(Starter, kit_1)"], id="kit-1")).result()
    job = station.jobs.wait("kit-1", 30.0)

    assert not result.repeated
    assert job.outcome == "succeeded"
    assert station.jobs.order(JobOrder(goal=["InKit(Starter, kit_1)"], id="kit-1")).result().repeated
    assert station.jobs.report("kit-1").steps


def test_a_program_edits_the_world_with_the_same_checks_as_a_client(opened: Opened) -> None:
    station = opened()
    added = station.elements.add(
        NewElement(**{"class": "kitting:Starter", "placement": {"relation": "sk:in", "place": "pallet_a"}})
    )

    with pytest.raises(StaleVersion):
        station.elements.change(added.id, ElementPatch(label="x"), Seen(added.version - 1))
    changed = station.elements.change(added.id, ElementPatch(label="x"))

    assert changed.label == "x"


def test_a_refusal_in_the_python_api_has_its_code(opened: Opened) -> None:
    station = opened()

    with pytest.raises(Refused) as refused:
        station.simulation.true_bodies()
    assert refused.value.code == "NoSimulation"
    assert station.goals.check(GoalOrder(goal=["InKit(Starter, kit_1)"])).conditions
