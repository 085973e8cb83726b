"""What a job looked like, over REST."""

from __future__ import annotations

import gzip
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest
from mcap.reader import make_reader
from support.serving import Served, serving

from skiros_py.api.view import Replay
from skiros_py.client.client import Client
from skiros_py.station.session import Options

PATIENCE = 60.0


def api(server: Served) -> httpx2.Client:
    return httpx2.Client(base_url=f"{server.url}/api/v1", timeout=PATIENCE)


def awaited(http: httpx2.Client, job: str, *states: str) -> dict[str, Any]:
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        found: dict[str, Any] = http.get(f"/jobs/{job}").json()
        if found["state"]["text"] in states:
            return found
        time.sleep(0.01)
    raise AssertionError(f"job {job} came to none of {states}")


def written(http: httpx2.Client, job: str) -> Replay:
    """Returns the replay of a job that is over, as soon as its end is on the disk."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        answer = http.get(f"/jobs/{job}/replay")
        if answer.status_code == 200 and answer.json()["complete"]:
            return Replay.model_validate_json(answer.content)
        time.sleep(0.01)
    raise AssertionError(f"the replay of {job} was never complete")


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as running:
        yield running


@pytest.fixture(scope="module")
def replay(server: Served) -> Replay:
    with api(server) as http:
        http.put("/jobs/kit", json={"goal": "InKit(Starter, kit_1)"}).raise_for_status()
        awaited(http, "kit", "Ended")
        return written(http, "kit")


def test_a_replay_starts_with_the_world_before_the_job_and_lists_visible_changes(replay: Replay) -> None:
    places = [{element.id: element.place for element in replay.beginning.elements}["starter_1"]]
    for change in replay.changes:
        places += [element.place for element in change.view.elements if element.id == "starter_1"]
    assert places == ["pallet_a", "gripper_1", "kit_1_a"]
    assert {change.author for change in replay.changes} == {"drive", "pick", "place"}
    times = [change.time for change in replay.changes]
    assert times == sorted(times)
    assert replay.start <= times[0]
    assert times[-1] <= replay.end


def test_a_replay_samples_all_devices_at_the_same_ascending_times(replay: Replay) -> None:
    frames = replay.frames
    assert list(frames.times) == sorted(set(frames.times))
    assert 2 <= len(frames.times) <= 5000
    assert {"robot_1/panda_joint1", "robot_1/panda_joint7", "robot_1/panda_finger_joint1"} <= set(frames.joints)
    assert {"base_1", "arm_1", "gripper_1", "camera_1"} <= set(frames.frames)
    assert {"base_1", "arm_1", "force_torque_1", "gripper_1", "localiser_1", "scanner_1"} == set(frames.states)
    tracks = (*frames.joints.values(), *frames.frames.values(), *frames.states.values())
    assert {len(track) for track in tracks} == {len(frames.times)}
    assert {len(pose) for pose in frames.frames["base_1"]} == {7}


def test_a_replay_can_be_read_by_time_range(server: Served, replay: Replay) -> None:
    middle = (replay.start + replay.end) / 2.0
    with Client(server.url) as client:
        first, second = client.jobs.replay("kit", end=middle), client.jobs.replay("kit", middle)

    assert (first.start, first.end) == (second.start, second.end) == (replay.start, replay.end)
    assert (*first.changes, *second.changes) == replay.changes
    assert sorted({*first.frames.times, *second.frames.times}) == list(replay.frames.times)
    assert first.beginning == replay.beginning != second.beginning


def test_a_replay_is_compressed_for_clients_that_accept_it(server: Served, replay: Replay) -> None:
    with api(server) as http:
        plain = http.get("/jobs/kit/replay", headers={"Accept-Encoding": "identity"})
        refused = http.get("/jobs/kit/replay", headers={"Accept-Encoding": "br, gzip;q=0"})
        with http.stream("GET", "/jobs/kit/replay", headers={"Accept-Encoding": "br, gzip"}) as packed:
            raw = b"".join(packed.iter_raw())
    assert packed.headers["Content-Encoding"] == "gzip"
    assert "Content-Encoding" not in plain.headers
    assert "Content-Encoding" not in refused.headers
    assert gzip.decompress(raw) == plain.content
    assert len(raw) < len(plain.content) / 3
    assert Replay.model_validate_json(plain.content) == replay


def test_the_recording_file_can_be_downloaded_completely_or_in_ranges(
    server: Served, replay: Replay, tmp_path: Path
) -> None:
    with api(server) as http:
        whole = http.get("/jobs/kit/recording")
        part = http.get("/jobs/kit/recording", headers={"Range": "bytes=0-7"})
    (tmp_path / "kit.mcap").write_bytes(whole.content)
    with (tmp_path / "kit.mcap").open("rb") as file:
        topics = {channel.topic for _, channel, _ in make_reader(file, validate_crcs=True).iter_messages()}
    assert {"/frames", "/scene", "/view", "/runs", "/trace", "/log", "/devices/arm_1"} <= topics
    assert (part.status_code, part.content) == (206, b"\x89MCAP0\r\n")


def test_the_client_reads_a_replay(server: Served, replay: Replay) -> None:
    with Client(server.url) as client:
        assert client.jobs.replay("kit") == replay
        assert client.jobs.recording("kit").startswith(b"\x89MCAP0\r\n")


def test_the_replay_of_a_job_that_has_not_started_is_refused_with_a_reason(server: Served) -> None:
    with api(server) as http:
        http.put("/jobs/later?start=false", json={"goal": "InKit(Starter, kit_1)"}).raise_for_status()
        answer, unknown = http.get("/jobs/later/replay"), http.get("/jobs/never/replay")
    assert (answer.status_code, answer.json()["code"]) == (404, "NoReplay")
    assert "it has not begun" in answer.json()["detail"]
    assert (unknown.status_code, unknown.json()["code"]) == (404, "UnknownJobOrderID")


def test_a_replay_is_deleted_together_with_its_job(tmp_path: Path) -> None:
    with serving("kitting", tmp_path) as server, api(server) as http:
        http.put("/jobs/kit", json={"goal": "InKit(Starter, kit_1)"}).raise_for_status()
        awaited(http, "kit", "Ended")
        written(http, "kit")
        kept = list((tmp_path / "recordings").iterdir())
        http.post("/jobs/kit/clear").raise_for_status()
        assert http.get("/jobs/kit/replay").status_code == 404
    assert len(kept) == 1
    assert list((tmp_path / "recordings").iterdir()) == []


def test_requesting_a_deleted_recording_is_answered_with_that_reason(tmp_path: Path) -> None:
    with serving("kitting", tmp_path) as server, api(server) as http:
        http.put("/jobs/kit", json={"goal": "InKit(Starter, kit_1)"}).raise_for_status()
        awaited(http, "kit", "Ended")
        written(http, "kit")
        for file in (tmp_path / "recordings").iterdir():
            file.unlink()
        answer = http.get("/jobs/kit/replay")
    assert (answer.status_code, answer.json()["code"]) == (404, "NoReplay")
    assert "it is kept no longer" in answer.json()["detail"]


def test_the_replay_of_an_interrupted_job_shows_both_parts_and_is_not_complete(tmp_path: Path) -> None:
    slow = Options(fake=True, pace=1.0)
    with serving("kitting", tmp_path, slow) as server, api(server) as http:
        http.put("/jobs/kit", json={"goal": "InKit(Starter, kit_1)"}).raise_for_status()
        awaited(http, "kit", "Running")
        running = http.get("/jobs/kit/replay")
    with serving("kitting", tmp_path) as server, api(server) as http:
        job = awaited(http, "kit", "Interrupted", "AllowedToStart", "Running", "Ended")
        before = http.get("/jobs/kit/replay").json()
        if job["choices"]:
            http.post("/jobs/kit/answer", json={"answer": job["choices"][0]}).raise_for_status()
        awaited(http, "kit", "Ended", "Aborted")
        deadline = time.monotonic() + PATIENCE
        while not (after := http.get("/jobs/kit/replay").json())["shifts"] and time.monotonic() < deadline:
            time.sleep(0.01)

    assert running.status_code == 404 or not running.json()["complete"]
    assert not before["complete"]
    assert not after["complete"]
    assert [change["whole"] for change in after["changes"]].count(True) == 1
    assert after["frames"]["times"] == sorted(set(after["frames"]["times"]))
    assert after["end"] > before["end"]
