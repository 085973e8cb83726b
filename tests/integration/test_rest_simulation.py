"""The simulation over REST, and bodies that follow what people write while nothing runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from io import BytesIO
from typing import Any

import httpx2
import pytest
from PIL import Image
from support.serving import Served, serving

from skiros_py.api.alarms import AlarmInfo, AlarmKind
from skiros_py.client.client import Client
from skiros_py.client.topics import Simulation
from skiros_py.devices.mobile_base import BaseSpec, BaseState
from skiros_py.errors import WrongState
from skiros_py.geometry import Pose
from skiros_py.station.session import Options
from skiros_py.world.change import Writer
from skiros_py.world.element import Placement
from skiros_py.world.transaction import Transaction
from skiros_py.world.undo import undo


@pytest.fixture(scope="module")
def pretending(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("fake"), Options(fake=True, pace=2.0)) as server:
        yield server


def test_without_physics_there_are_no_bodies_and_no_pictures(pretending: Served) -> None:
    with httpx2.Client(base_url=f"{pretending.url}/api/v1") as http:
        answers = [
            http.get("/simulation/bodies"),
            http.put("/simulation/bodies/starter_1/pose", json={"position": [1, 1, 1]}),
            http.delete("/simulation/bodies/starter_1"),
            http.get("/simulation/picture"),
        ]
    assert {(answer.status_code, answer.json()["code"]) for answer in answers} == {(409, "NoSimulation")}


def test_a_new_pace_takes_effect_at_once_and_survives_a_reset(pretending: Served) -> None:
    with Client(pretending.url) as client:
        client.send(Simulation.set_pace(20.0))
        client.send(Simulation.set_pace(0.05))
        client.send(Simulation.set_pace(20.0))
        assert client.send(Simulation.get()).pace == 20.0
        assert client.send(Simulation.reset()).pace == 20.0


@pytest.mark.parametrize("pace", ["0.01", "21", "NaN", "1e308", '"fast"', "null", "-1", "Infinity"])
def test_invalid_paces_are_refused(pretending: Served, pace: str) -> None:
    with httpx2.Client(base_url=f"{pretending.url}/api/v1") as http:
        answer = http.put(
            "/simulation/pace", content=f'{{"pace": {pace}}}', headers={"Content-Type": "application/json"}
        )
    assert answer.status_code in (400, 422)


def stale_alarms(served: Served) -> list[AlarmInfo]:
    return [alarm for alarm in served.services.station.alarms.active if alarm.kind is AlarmKind.STALE]


def test_editing_a_robot_is_reported_to_need_a_reset(pretending: Served) -> None:
    services = pretending.services
    with services.station.session.world.transaction("ann", "elsewhere", writer=Writer.PERSON) as tx:
        tx.set("base_1", "sk:maxLinear", 0.5)
    services.station.control.call(lambda _: None)

    assert "base_1 was changed" in services.station.simulation.state().stale[0]
    (alarm,) = stale_alarms(pretending)
    assert (alarm.source, alarm.severity) == ("base_1", "low")
    assert "base_1 was changed" in alarm.text
    services.station.simulation.reset(force=False)
    assert services.station.simulation.state().stale == []
    assert stale_alarms(pretending) == []
    assert services.station.control.call(lambda s: s.spec.device("base_1", BaseSpec)).max_linear == 0.5


def test_a_robot_without_physics_that_was_put_elsewhere_stands_there_and_needs_no_reset(pretending: Served) -> None:
    services = pretending.services
    with services.station.session.world.transaction("ann", "elsewhere", writer=Writer.PERSON) as tx:
        tx.set("base_1", "sk:pose", Pose.of(0.5, 0.0, 0.0))
    with httpx2.Client(base_url=f"{pretending.url}/api/v1") as http:
        poses = iter(lambda: http.get("/robots/robot_1/state").json()["pose"]["position"], None)
        assert next(pose for pose in poses if pose != [0.0, 0.0, 0.0]) == [0.5, 0.0, 0.0]

    assert services.station.simulation.state().stale == []
    services.station.simulation.reset(force=False)
    base = services.station.control.call(lambda s: s.cycle.board.snapshot.state("base_1", BaseState))
    assert base.pose.position[0] == 0.5


# ---------------------------------------------------------------- with physics


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data"), Options(seed=1)) as server:
        yield server


@pytest.fixture
def fresh(served: Served) -> Served:
    """The server, with the scene as it was, and bodies as they are believed."""
    with httpx2.Client(base_url=f"{served.url}/api/v1", timeout=120.0) as http:
        http.put("/scene", json={"name": "kitting"}, headers={"If-Match": "*"}).raise_for_status()
    return served


def write(served: Served, what: Callable[[Transaction], object], writer: Writer = Writer.PERSON) -> None:
    with served.services.station.session.world.transaction("ann", "builds the scene", writer=writer) as tx:
        what(tx)


def bodies(served: Served) -> dict[str, Any]:
    return {body.id: body for body in served.services.station.simulation.true_bodies().items}


@pytest.mark.physics
def test_a_part_added_by_a_person_appears_in_the_simulation_until_the_change_is_undone(fresh: Served) -> None:
    write(fresh, lambda tx: tx.add("kitting:Starter", id="starter_7", placement=Placement("sk:in", "pallet_b")))
    assert bodies(fresh)["starter_7"].place == "pallet_b"

    undo(fresh.services.station.session.world, "ann")
    assert "starter_7" not in bodies(fresh)


@pytest.mark.physics
def test_a_part_moved_or_removed_by_a_person_is_moved_or_removed_in_the_simulation(fresh: Served) -> None:
    write(fresh, lambda tx: tx.place("starter_1", "sk:in", "pallet_b"))
    write(fresh, lambda tx: tx.remove("compressor_1"))

    found = bodies(fresh)
    assert found["starter_1"].place == "pallet_b"
    assert "compressor_1" not in found
    assert found["alternator_1"].place == "pallet_a"


@pytest.mark.physics
def test_a_body_is_not_moved_into_another_one_and_the_reason_is_data(fresh: Served) -> None:
    before = bodies(fresh)["starter_1"].position
    with httpx2.Client(base_url=f"{fresh.url}/api/v1", timeout=60.0) as http:
        path = "/simulation/bodies/starter_1/pose"
        refused = http.put(path, json={"position": [*before[:2], before[2] - 0.05]})
        checked = http.put(path, params={"check": True}, json={"position": [1.0, 1.0, 1.5]})
    problem = refused.json()
    assert (refused.status_code, problem["code"], set(problem["hits"])) == (409, "Collision", {"pallet_a"})
    assert problem["hits"]["pallet_a"] > 0.01
    assert checked.status_code == 204
    assert bodies(fresh)["starter_1"].position == pytest.approx(before, abs=1e-3)


@pytest.mark.physics
def test_a_body_does_not_follow_a_belief_into_another_body_and_an_alarm_says_why(fresh: Served) -> None:
    before = bodies(fresh)["starter_1"].position
    write(fresh, lambda tx: tx.set("starter_1", "sk:pose", Pose.of(*before[:2], before[2] - 0.05)))
    after = bodies(fresh)["starter_1"].position

    assert after == pytest.approx(before, abs=1e-3)
    assert "starter_1 stays as it is: there it would be inside pallet_a" in stale_alarms(fresh)[0].text


@pytest.mark.physics
def test_labels_and_changes_by_skills_move_no_simulated_body(fresh: Served) -> None:
    before = bodies(fresh)["starter_1"].position
    write(fresh, lambda tx: tx.set("starter_1", "rdfs:label", "the starter"))
    write(fresh, lambda tx: tx.place("starter_1", "sk:in", "pallet_b"), writer=Writer.SKILL)

    assert bodies(fresh)["starter_1"].position == pytest.approx(before, abs=1e-3)


@pytest.mark.physics
def test_furniture_moved_by_a_person_takes_its_compartments_along(fresh: Served) -> None:
    before = bodies(fresh)
    write(fresh, lambda tx: tx.set("kit_1", "sk:pose", Pose.of(-1.55, 0.1, 0.5)))

    found = bodies(fresh)
    assert found["kit_1"].position == pytest.approx([-1.55, 0.1, 0.5])
    for name in ("kit_1_a", "kit_1_d"):
        assert found[name].position != pytest.approx(before[name].position, abs=0.05)
        offsets = [abs(a - b) for a, b in zip(found[name].position, found["kit_1"].position, strict=True)]
        assert offsets == pytest.approx([0.073, 0.073, 0.006], abs=1e-6)


@pytest.mark.physics
def test_an_added_part_that_the_simulation_cannot_place_is_reported(fresh: Served) -> None:
    write(fresh, lambda tx: tx.add("kitting:Starter", id="starter_8", placement=Placement("sk:on", "floor")))
    fresh.services.station.control.call(lambda _: None)

    assert "starter_8" not in bodies(fresh)
    assert any("starter_8" in sentence for sentence in fresh.services.station.simulation.state().stale)
    fresh.services.station.simulation.reset(force=False)
    assert fresh.services.station.session.world.value("starter_8", "sk:missing") is True


@pytest.mark.physics
def test_an_incomplete_element_does_not_prevent_a_start_and_raises_an_alarm(fresh: Served) -> None:
    pose = fresh.services.station.session.world.value("pallet_a", "sk:pose")
    write(fresh, lambda tx: tx.set("pallet_a", "sk:pose", None))
    with pytest.raises(WrongState, match="pallet_a has neither a pose nor a place"):
        fresh.services.station.simulation.reset(force=False)
    fresh.services.station.control.reopen()  # as a server does that is started anew

    assert "pallet_a" not in bodies(fresh)
    said = {alarm.source: alarm.text for alarm in stale_alarms(fresh)}
    assert "pallet_a has neither a pose nor a place" in said["pallet_a"]
    assert said["starter_1"].endswith("it lies in pallet_a, which is not there")

    write(fresh, lambda tx: tx.set("pallet_a", "sk:pose", pose))
    assert "pallet_a" in bodies(fresh)
    assert "pallet_a" not in {alarm.source for alarm in stale_alarms(fresh)}
    fresh.services.station.simulation.reset(force=False)
    assert stale_alarms(fresh) == []
    assert bodies(fresh)["starter_1"].place == "pallet_a"


@pytest.mark.physics
def test_a_lost_part_does_not_prevent_a_restart_of_the_station(fresh: Served) -> None:
    def lose(tx: Transaction) -> None:
        tx.place("starter_1", "sk:on", "unknown_location")
        tx.set("starter_1", "sk:missing", True)

    write(fresh, lose, writer=Writer.SKILL)
    with Client(fresh.url, timeout=120.0) as client:
        client.send(Simulation.reset())
    assert "starter_1" not in bodies(fresh)

    write(fresh, lambda tx: tx.place("starter_1", "sk:in", "pallet_a"))
    assert bodies(fresh)["starter_1"].place == "pallet_a"


@pytest.mark.physics
def test_moving_a_simulated_body_does_not_change_the_world_model(fresh: Served) -> None:
    version = fresh.services.station.session.world.version
    with Client(fresh.url) as client:
        client.send(Simulation.move_body("starter_1", (2.0, 2.5, 0.0)))
        client.send(Simulation.remove_body("compressor_1"))
        found = {body.id: body for body in client.send(Simulation.bodies()).items}

    assert found["starter_1"].position[:2] == pytest.approx([2.0, 2.5], abs=1e-2)
    assert "compressor_1" not in found
    assert fresh.services.station.session.world.version == version


@pytest.mark.physics
@pytest.mark.parametrize(
    "pose",
    [
        '{"position": [NaN, 0, 0]}',
        '{"position": [1e308, 0, 0]}',
        '{"position": [0, 0]}',
        '{"position": [0, 0, 0], "orientation": [0, 0, 0, 0]}',
    ],
)
def test_invalid_poses_of_bodies_are_refused(served: Served, pose: str) -> None:
    with httpx2.Client(base_url=f"{served.url}/api/v1") as http:
        headers = {"Content-Type": "application/json"}
        assert http.put("/simulation/bodies/starter_1/pose", content=pose, headers=headers).status_code in (400, 422)
        assert http.put("/simulation/bodies/kit_1_a/pose", json={"position": [0, 0, 1]}).status_code == 409
        assert http.delete("/simulation/bodies/nobody").json()["code"] == "UnknownBody"


@pytest.mark.physics
def test_a_picture_is_rendered_from_the_requested_viewpoint(served: Served) -> None:
    with Client(served.url, timeout=60.0) as client:
        pictures = [
            client.send(Simulation.picture(eye, (0.0, 0.0, 0.3), width=160, height=120))
            for eye in ((3.0, -3.0, 2.5), (0.0, 0.0, 6.0))
        ]
    images = [Image.open(BytesIO(picture)) for picture in pictures]

    assert {image.size for image in images} == {(160, 120)}
    assert all(len(image.convert("L").getcolors()) > 10 for image in images)
    with httpx2.Client(base_url=f"{served.url}/api/v1") as http:
        for query in ({"eye": "0,0,0", "target": "0,0,0"}, {"width": "100000"}, {"eye": "1,2"}, {"eye": "nan,0,0"}):
            assert http.get("/simulation/picture", params=query).status_code == 422


@pytest.mark.physics
def test_simultaneous_picture_requests_each_get_a_picture_or_a_retry_time(served: Served) -> None:
    with httpx2.Client(base_url=f"{served.url}/api/v1", timeout=60.0) as http, ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda _: http.get("/simulation/picture?width=320&height=240"), range(8)))

    assert {answer.status_code for answer in answers} <= {200, 503}
    assert 200 in {answer.status_code for answer in answers}
    assert all("Retry-After" in answer.headers for answer in answers if answer.status_code == 503)
