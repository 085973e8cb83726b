"""Case 2: a server that is killed at the worst moments loses nothing it has acknowledged, and does nothing twice."""

from __future__ import annotations

import itertools
import random
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx2
from support.server_process import ServerProcess

from .hard import ANYHOW, HOLDS, LATER, STARTER, HeldPlanner, cycles, job_of, over, steps, until

START = ("--fake", "--pace", "5")


@contextmanager
def started(data: Path, *more: str) -> Iterator[tuple[ServerProcess, httpx2.Client]]:
    first = () if (data / "journal.db").exists() else ("kitting",)
    with (
        ServerProcess(*first, *START, *more, data=data) as server,
        httpx2.Client(base_url=f"{server.url}/api/v1", timeout=60.0) as api,
    ):
        yield server, api


def assert_held(api: httpx2.Client, id_: str) -> None:
    """A job waits for a person with a reason, and nothing is done for it by itself."""
    job, before = job_of(api, id_), steps(api, id_)
    assert (job["state"]["text"], job["state"]["substates"]) == ("Interrupted", ["Held"])
    assert job["detail"]
    assert {"retry", "abort"} <= set(job["choices"])
    cycles(api, 100)
    assert job_of(api, id_) == job
    assert steps(api, id_) == before
    assert api.get("/state").json()["modules"] == []


def placed(api: httpx2.Client, part: str) -> int:
    """Returns how often a part came into the kit."""
    changes = api.get(f"/elements/{part}/history", params={"limit": 200}).raise_for_status().json()["items"]
    edits = (edit for change in changes for edit in change["edits"] if edit["edit"] == "placement")
    return sum(str((edit["new"] or {}).get("place", "")).startswith("kit_1_") for edit in edits)


def test_after_a_kill_running_jobs_wait_for_a_person_and_nothing_is_done_twice(tmp_path: Path) -> None:
    planner, data = HeldPlanner(tmp_path), tmp_path / "data"
    with started(data, "--planner-command", planner.command) as (server, api):
        api.put("/jobs/kit", json=STARTER).raise_for_status()
        waits, posted = order_for_later(api)
        until(lambda: len(planner.processes) == 2)
        server.kill()
    planner.let_go()
    with started(data, "--planner-command", planner.command) as (server, api):
        assert_held(api, "kit")
        assert steps(api, "kit") == []
        retry_and_kill_after_steps(server, api, "kit", 2)  # it has driven, and picked the part
    with started(data, "--planner-command", planner.command) as (_, api):
        assert_held(api, "kit")
        assert api.put("/jobs/kit", json=STARTER).json()["state"]["substates"] == ["Held"]
        assert steps(api, "kit")[:2] == ["drive", "pick"]
        api.post("/jobs/kit/answer", json={"answer": "retry"}).raise_for_status()
        assert over(api, "kit")["outcome"] == "succeeded"
        assert steps(api, "kit").count("pick") == 1
        assert placed(api, "starter_1") == 1
        assert order_for_later(api) == (waits, posted)


def order_for_later(api: httpx2.Client) -> tuple[Any, Any]:
    """Orders two jobs that wait, and returns the answers: the same ones whenever that is said again."""
    order, key = {**HOLDS, **LATER}, {"Idempotency-Key": "once"}
    return api.put("/jobs/waits", json=order).json(), api.post("/jobs", json=order, headers=key).json()


def retry_and_kill_after_steps(server: ServerProcess, api: httpx2.Client, id_: str, many: int) -> None:
    """Retries a held job and kills the server when so many steps have ended; fails if it is held or over before."""
    ended, held = 0, job_of(api, id_)["version"]
    api.post(f"/jobs/{id_}/answer", json={"answer": "retry"}).raise_for_status()
    with api.sse(f"/jobs/{id_}/events") as source:
        for event in source:
            told = event.json() if event.event in ("task", "job") else {}
            ended += event.event == "task" and told["type"] == "ended"
            if ended == many:
                break
            if event.event == "job" and told["data"]["version"] > held:
                # On a machine that stalls for seconds everything is halted; then no further step ends.
                waits = told["data"]["choices"] or told["data"]["outcome"]
                assert not waits, f"{told['data']}\n{server.said}"
        server.kill()


class Writer(threading.Thread):
    """Orders, edits and saves as fast as it can until the server is gone, and keeps what was acknowledged.

    Attributes:
        jobs: Ids of the jobs that were taken.
        label: The last label that was written.
        scenes: Names of the scenes that were saved.
        next: What it was about to do when the server was gone: that may be there, or not.
    """

    def __init__(self, api: httpx2.Client, round_: int) -> None:
        super().__init__()
        self._api, self._round = api, round_
        self.jobs: list[str] = []
        self.label = ""
        self.scenes: list[str] = []
        self.next = ""

    def run(self) -> None:
        try:
            for number in itertools.count():
                self._write(f"{self._round}-{number}")
        except httpx2.TransportError:
            pass  # it is gone

    def _write(self, name: str) -> None:
        self.next = name
        self._api.put(f"/jobs/{name}", json={**HOLDS, **LATER}).raise_for_status()
        self.jobs.append(name)
        self._api.patch("/elements/rack_1", json={"label": name}, headers=ANYHOW).raise_for_status()
        self.label = name
        self._api.post("/scenes", json={"name": f"scene-{name}"}).raise_for_status()
        self.scenes.append(f"scene-{name}")


def test_kills_at_random_moments_lose_no_order_no_edit_and_no_scene(tmp_path: Path) -> None:
    rng, data = random.Random(11), tmp_path / "data"
    written: list[Writer] = []
    for round_ in range(2):
        with started(data) as (server, api):
            assert_all_kept(api, written)
            api.put(f"/jobs/run-{round_}", json=STARTER).raise_for_status()
            writer = Writer(api, round_)
            writer.start()
            until(lambda: len(writer.scenes) > 2 or not writer.is_alive())  # noqa: B023 - called here only
            time.sleep(rng.uniform(0.1, 1.0))
            server.kill()
            writer.join()
            written.append(writer)
    leave_half_a_scene(data / "scenes")
    with started(data) as (_, api):
        assert_all_kept(api, written)
        saved = {one["name"] for one in pages(api, "/scenes") if one["source"] == "saved"}
        assert saved - {f"scene-{writer.next}" for writer in written} == {s for w in written for s in w.scenes}
        seen = api.get(f"/scenes/{written[0].scenes[0]}").headers["etag"]
        again = api.post("/scenes", json={"name": written[0].scenes[0]}, headers={"If-Match": seen})
        assert again.status_code == 201
    assert all(len(writer.jobs) > 2 and len(writer.scenes) > 2 for writer in written)


def leave_half_a_scene(folder: Path) -> None:
    """Leaves what a kill between writing a file and giving it its name leaves."""
    whole = next(folder.glob("*.ttl")).read_bytes()
    (folder / ".mine.ttl.0badcafe.tmp").write_bytes(whole[: len(whole) // 2])


def assert_all_kept(api: httpx2.Client, written: list[Writer]) -> None:
    """All that was acknowledged is there, and whole; what was cut off is held."""
    for round_, writer in enumerate(written):
        for id_ in writer.jobs:
            assert job_of(api, id_)["order"]["goal"] == [HOLDS["goal"]]
        for scene in writer.scenes[-2:]:
            assert api.get(f"/scenes/{scene}").raise_for_status().json()["elements"] > 10
        assert api.get(f"/scenes/scene-{writer.next}").status_code in (200, 404)  # and never half of one
        run = job_of(api, f"run-{round_}")
        assert run["outcome"] or run["state"]["substates"] == ["Held"] or steps(api, run["id"]) == []
    if written:
        assert api.get("/elements/rack_1").json()["label"] in (written[-1].label, written[-1].next)


def pages(api: httpx2.Client, path: str) -> Iterator[dict[str, Any]]:
    query: dict[str, Any] = {"limit": 1000}
    while True:
        page = api.get(path, params=query).raise_for_status().json()
        yield from page["items"]
        if page["next"] is None:
            return
        query["cursor"] = page["next"]
