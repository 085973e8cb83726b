"""Documents over REST: written with revisions, refused with the place of a fault, run and drawn as modules."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest
from click.testing import CliRunner
from support.serving import serving

from skiros_py.cli.main import cli

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


def test_a_document_has_revisions_and_is_overwritten_only_with_its_latest_version(api: httpx2.Client) -> None:
    first = written(api, "twice")
    blind = written(api, "twice")
    second = written(api, "twice", {"type": "wait", "seconds": 1}, **{"If-Match": first.headers["ETag"]})
    stale = written(api, "twice", **{"If-Match": first.headers["ETag"]})

    assert [answer.status_code for answer in (first, blind, second, stale)] == [201, 428, 200, 412]
    assert second.headers["ETag"] == f'"{second.json()["revision"]}"'
    revisions = api.get("/documents/tree/twice/revisions").json()["items"]
    assert [one["data"]["type"] for one in revisions] == ["sequence", "wait"]
    assert [one["id"] for one in api.get("/documents/tree").json()["items"]] == ["twice"]


def test_a_fault_in_a_document_is_answered_with_its_place(api: httpx2.Client) -> None:
    answer = written(api, "wrong", {"type": "sequence", "children": [{"type": "wait"}]})

    assert answer.status_code == 422
    assert "children[0]: it has no seconds" in answer.text
    assert answer.json()["faults"] == [{"place": "children[0]", "text": "it has no seconds", "line": 0, "column": 0}]
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


def test_a_document_is_exported_and_imported_as_text_in_the_formats_of_its_kind(api: httpx2.Client) -> None:
    tag = written(api, "by text").headers["ETag"]
    json_ = {"Content-Type": "application/json; charset=utf-8"}

    got = api.get("/documents/tree/by text/text")
    copy = api.put("/documents/tree/copy/text", content=got.text, headers=json_)
    blind = api.put("/documents/tree/by text/text", content=got.text, headers=json_)
    again = api.put("/documents/tree/by text/text", content=got.text, headers={**json_, "If-Match": tag})

    assert (got.headers["Content-Type"], got.headers["ETag"], json.loads(got.text)) == ("application/json", tag, TREE)
    assert [answer.status_code for answer in (copy, blind, again)] == [201, 428, 200]
    assert copy.json()["data"] == api.get("/documents/tree/copy").json()["data"] == TREE
    assert api.get("/documents/tree/by text/text", params={"format": "xml"}).status_code == 422
    assert api.get("/documents/tree/none such/text").status_code == 404
    xml = api.put("/documents/tree/copy/text", content="<tree/>", headers={"Content-Type": "application/xml"})
    assert (xml.status_code, "application/json" in xml.json()["detail"]) == (415, True)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ('{"type": "wait",\n "seconds" 1}', {"place": "", "line": 2, "column": 12}),
        ('{"type": "sequence", "children": [{"type": "wiat"}]}', {"place": "children[0]", "line": 1, "column": 35}),
        (
            '{"type": "sequence", "children": [\n {"type": "wait", "seconds": 1},\n  {"type": "do", "module": "fly"}]}',
            {"place": "1", "line": 3, "column": 3},
        ),
        (
            '{"parameters": [],\n "body": {"type": "sequence",\n  "children": [{"type": "wait"}]}}',
            {"place": "body.children[0]", "line": 3, "column": 16},
        ),
        (
            '{"parameters": [],\n "body": {"type": "sequence",\n  "children": [{"type": "do", "module": "fly"}]}}',
            {"place": "0", "line": 3, "column": 16},
        ),
        ('{"title": "",\n "body": {"type": "wait", "seconds": 1}}', {"place": "title", "line": 1, "column": 2}),
        ("[1, 2]", {"place": "", "line": 1, "column": 1}),
    ],
    ids=[
        "malformed",
        "of an unknown type",
        "beyond the station",
        "of an unknown type in a body",
        "beyond it in a body",
        "a field that is not known",
        "no object",
    ],
)
def test_a_fault_of_an_imported_text_is_answered_with_its_place_and_nothing_is_written(
    api: httpx2.Client, text: str, fault: dict[str, Any]
) -> None:
    answer = api.put("/documents/tree/half/text", content=text, headers={"Content-Type": "application/json"})

    assert answer.status_code == 422
    (found,) = answer.json()["faults"]
    assert {key: found[key] for key in fault} == fault
    assert api.get("/documents/tree/half").status_code == 404
    assert api.get("/documents/tree/half/revisions").json()["items"] == []


def test_a_removed_document_can_no_longer_be_run(api: httpx2.Client) -> None:
    seen = written(api, "gone").headers["ETag"]

    assert api.delete("/documents/tree/gone", headers={"If-Match": seen}).status_code == 204
    assert api.get("/documents/tree/gone").status_code == 404
    assert api.post("/modules/base_1/tree:gone/runs", json={}).status_code == 404


def test_document_kinds_list_the_nodes_that_an_editor_can_offer(api: httpx2.Client) -> None:
    kinds = {kind["kind"]: kind for kind in api.get("/documents").json()["items"]}

    offered = {node["kind"]: node for node in kinds["tree"]["palette"]}
    assert offered["wait"]["fields"] == {"seconds": "float"}
    assert kinds["tree"]["formats"] == {"json": "application/json"}
    assert {"tree", "sequence", "template"} <= kinds.keys()


def test_the_last_fifty_revisions_are_kept(api: httpx2.Client) -> None:
    first = written(api, "often")
    seen = first.headers["ETag"]
    for _ in range(55):
        seen = written(api, "often", **{"If-Match": seen}).headers["ETag"]

    kept = [one["revision"] for one in api.get("/documents/tree/often/revisions").json()["items"]]
    assert len(kept) == 50
    assert f'"{kept[-1]}"' == seen
    assert first.json()["revision"] not in kept


def test_a_document_is_written_run_and_debugged_from_the_shell(api: httpx2.Client, tmp_path: Path) -> None:
    url = str(api.base_url).removesuffix("/api/v1/")
    file = tmp_path / "pauses.json"
    file.write_text(json.dumps(TREE), encoding="utf-8")

    def said(*arguments: str) -> Any:
        result = CliRunner().invoke(cli, ("document", *arguments, "--url", url, "--json"), catch_exceptions=False)
        assert result.exit_code == 0, result.output
        return json.loads(result.stdout)

    def status(run: str) -> str:
        answer: str = api.get(f"/module-runs/{run}").json()["status"]
        return answer

    def wait_for(run: str, wanted: str) -> None:
        deadline = time.monotonic() + 30
        while status(run) != wanted:
            assert time.monotonic() < deadline, f"{status(run)}, not {wanted}"
            time.sleep(0.02)

    assert said("import", "tree", "by hand", str(file))["module"] == "tree:by hand"
    assert said("import", "tree", "by hand", str(file))["revision"] > 0
    assert said("show", "tree", "by hand")["data"] == TREE
    assert json.loads(said("export", "tree", "by hand")["text"]) == TREE
    assert "by hand" in [one["id"] for one in said("list", "tree")["items"]]

    run = said("run", "tree", "by hand", "--agent", "base_1", "--break", "body/0", "--break", "body/1")["id"]
    wait_for(run, "paused")
    assert said("break", run, "body/1")["breakpoints"] == ["tree:by hand/body/1"]
    said("command", run, "resume")
    wait_for(run, "paused")
    assert said("break", run)["breakpoints"] == []
    said("command", run, "resume")
    wait_for(run, "succeeded")
    assert said("remove", "tree", "by hand") == {"removed": "tree:by hand"}
