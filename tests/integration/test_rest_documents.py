"""Documents over REST: written with revisions, refused with the place of a fault, run and drawn as modules."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import httpx2
import pytest
from support.serving import serving

TREE = {"type": "sequence", "children": [{"type": "wait", "seconds": 0.05}, {"type": "wait", "seconds": 0.05}]}


@pytest.fixture(scope="module")
def api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[httpx2.Client]:
    with (
        serving("kitting", tmp_path_factory.mktemp("data")) as served,
        httpx2.Client(base_url=f"{served.url}/api/v1") as client,
    ):
        yield client


def written(api: httpx2.Client, id_: str, data: Any = TREE, **headers: str) -> httpx2.Response:
    return api.put(f"/documents/tree/{id_}", json={"data": data}, headers=headers)


def test_a_document_is_written_with_revisions_and_only_over_what_was_seen(api: httpx2.Client) -> None:
    first = written(api, "twice")
    blind = written(api, "twice")
    second = written(api, "twice", {"type": "wait", "seconds": 1}, **{"If-Match": first.headers["ETag"]})
    stale = written(api, "twice", **{"If-Match": first.headers["ETag"]})

    assert [answer.status_code for answer in (first, blind, second, stale)] == [201, 428, 200, 412]
    assert second.headers["ETag"] == f'"{second.json()["revision"]}"'
    revisions = api.get("/documents/tree/twice/revisions").json()["documents"]
    assert [one["data"]["type"] for one in revisions] == ["sequence", "wait"]
    assert [one["id"] for one in api.get("/documents/tree").json()["documents"]] == ["twice"]


def test_a_fault_is_answered_with_its_place(api: httpx2.Client) -> None:
    answer = written(api, "wrong", {"type": "sequence", "children": [{"type": "wait"}]})

    assert answer.status_code == 422
    assert "children[0]: it has no seconds" in answer.text
    assert api.get("/documents/tree/wrong").status_code == 404
    assert api.get("/documents/nokind").status_code == 404


def test_a_document_is_drawn_and_run_as_a_module_without_a_restart(api: httpx2.Client) -> None:
    revision = written(api, "pauses").json()["revision"]

    drawn = api.get("/modules/base_1/tree:pauses").json()
    (way,) = drawn["implementations"]
    assert (drawn["kind"], way["label"]) == ("document", f"revision {revision}")
    assert [node["path"] for node in way["nodes"]] == ["body", "body/0", "body/1"]

    run = api.post("/modules/base_1/tree:pauses/runs", json={}).json()
    deadline = time.monotonic() + 30
    while api.get(f"/module-runs/{run['id']}").json()["status"] == "running" and time.monotonic() < deadline:
        time.sleep(0.05)
    done = api.get(f"/module-runs/{run['id']}").json()
    assert done["status"] == "succeeded"
    assert [row["path"] for row in done["progress"]] == ["tree:pauses", "tree:pauses"]


def test_a_removed_document_runs_no_more(api: httpx2.Client) -> None:
    seen = written(api, "gone").headers["ETag"]

    assert api.delete("/documents/tree/gone", headers={"If-Match": seen}).status_code == 204
    assert api.get("/documents/tree/gone").status_code == 404
    assert api.post("/modules/base_1/tree:gone/runs", json={}).status_code == 404


def test_the_kinds_tell_the_nodes_that_an_editor_offers(api: httpx2.Client) -> None:
    kinds = {kind["kind"]: kind for kind in api.get("/documents").json()["kinds"]}

    offered = {node["kind"]: node for node in kinds["tree"]["palette"]}
    assert offered["wait"]["fields"] == {"seconds": "float"}
    assert kinds["tree"]["formats"] == ["json"]
