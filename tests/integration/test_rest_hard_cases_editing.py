"""Cases 7, 10, 11 and 13: two engineers, broken uploads, worlds that make no sense, files that cannot be written."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import httpx2
import pytest
from support.serving import Served, serving

from skiros_py.server.access.roles import Role

from .hard import ANYHOW, SLOWLY, STARTER, api_of, begin_anew, moves, over, until

TURTLE = {**ANYHOW, "Content-Type": "text/turtle"}


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data"), SLOWLY) as served:
        served.services.keys.create("chief", Role.ADMIN)
        yield served


@pytest.fixture(scope="module")
def engineers(served: Served) -> Iterator[tuple[httpx2.Client, httpx2.Client]]:
    """Two people who do not know of each other."""
    secrets = [served.services.keys.create(name, Role.ENGINEER)[1] for name in ("anna", "bert")]
    with api_of(served, secrets[0]) as anna, api_of(served, secrets[1]) as bert:
        yield anna, bert


@pytest.fixture
def api(engineers: tuple[httpx2.Client, httpx2.Client]) -> httpx2.Client:
    begin_anew(engineers[0])
    return engineers[0]


# ------------------------------------------------------------------ case 7: two engineers


def test_an_edit_with_an_outdated_version_or_without_a_version_is_refused(
    api: httpx2.Client, engineers: tuple[httpx2.Client, httpx2.Client]
) -> None:
    _, bert = engineers
    seen = {"If-Match": api.get("/elements/rack_1").headers["etag"]}

    first = api.patch("/elements/rack_1", json={"label": "anna's"}, headers=seen)
    stale = bert.patch("/elements/rack_1", json={"label": "bert's"}, headers=seen)
    blind = bert.patch("/elements/rack_1", json={"label": "bert's"})

    assert (first.status_code, stale.status_code, blind.status_code) == (200, 412, 428)
    assert bert.get("/elements/rack_1").json()["label"] == "anna's"
    scene = {"If-Match": bert.get("/scene").headers["etag"]}
    api.patch("/elements/rack_1", json={"label": "once more"}, headers=ANYHOW).raise_for_status()
    assert bert.put("/scene", json={"name": "kitting_two"}, headers=scene).status_code == 412
    assert bert.put("/scene", json={"name": "kitting_two"}).status_code == 428


def test_an_element_locked_by_one_engineer_cannot_be_changed_by_another(
    api: httpx2.Client, engineers: tuple[httpx2.Client, httpx2.Client]
) -> None:
    _, bert = engineers
    api.post("/locks", json={"elements": ["kit_1"], "seconds": 60}).raise_for_status()
    there = {"placement": {"relation": "sk:in", "place": "kit_1_a"}}
    transaction = {
        "reason": "x",
        "operations": [{"op": "place", "element": "kit_1", "relation": "sk:on", "place": "floor"}],
    }
    try:
        refused = [
            bert.patch("/elements/kit_1", json={"label": "bert's"}, headers=ANYHOW),
            bert.patch("/elements/kit_1_a", json={"label": "bert's"}, headers=ANYHOW),
            bert.patch("/elements/starter_1", json=there, headers=ANYHOW),
            bert.delete("/elements/kit_1", headers=ANYHOW),
            bert.post("/world/transactions", json=transaction, headers=ANYHOW),
            bert.put("/scene", json={"name": "kitting_two"}, headers=ANYHOW),
        ]
        assert [answer.status_code for answer in refused] == [423] * len(refused), [a.text for a in refused]
        assert all("locked by anna" in answer.json()["detail"] for answer in refused)
        assert bert.delete("/locks", params={"elements": "kit_1", "owner": "anna"}).status_code in (403, 409, 422, 423)
    finally:
        api.delete("/locks", params={"elements": "kit_1"}).raise_for_status()
    assert bert.patch("/elements/kit_1", json={"label": "bert's"}, headers=ANYHOW).status_code == 200


def test_while_a_job_runs_the_scene_cannot_be_replaced_and_unrelated_edits_do_not_disturb_the_job(
    api: httpx2.Client, engineers: tuple[httpx2.Client, httpx2.Client]
) -> None:
    _, bert = engineers
    api.put("/jobs/kit", json=STARTER).raise_for_status()
    until(lambda: moves(api, "kit"))

    loaded = bert.put("/scene", json={"name": "kitting_two"}, headers=ANYHOW)
    edited = bert.patch("/elements/relay_box_2", json={"label": "painted"}, headers=ANYHOW)

    assert (loaded.status_code, edited.status_code) == (409, 200)
    assert over(api, "kit")["outcome"] == "succeeded"


def test_twenty_engineers_saving_one_scene_at_once_never_overwrite_an_unseen_version(
    api: httpx2.Client,
) -> None:
    seen = {"If-Match": api.post("/scenes", json={"name": "shared"}).headers["etag"]}

    def save(number: int) -> int:
        api.patch("/elements/rack_1", json={"label": f"rack {number}"}, headers=ANYHOW).raise_for_status()
        return api.post("/scenes", json={"name": "shared"}, headers=seen).status_code

    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(save, range(20)))
    assert answers.count(201) == 1
    assert answers.count(412) == 19


# ------------------------------------------------------------------ case 10: uploads


def rdf(body: str, head: str = "") -> bytes:
    return (
        f'<?xml version="1.0"?>{head}<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#" '
        f'xmlns:rdfs="http://www.w3.org/2000/01/rdf-schema#">{body}</rdf:RDF>'
    ).encode()


BOMB = "<!DOCTYPE x [<!ENTITY a0 'aaaaaaaaaa'>" + "".join(
    f"<!ENTITY a{n} '{f'&a{n - 1};' * 10}'>" for n in range(1, 10)
) + "]>"  # fmt: skip
COMMENT = "<rdf:Description rdf:about='urn:x'><rdfs:comment>{}</rdfs:comment></rdf:Description>"
UPLOADS: dict[str, tuple[bytes, str]] = {
    "entity bomb": (rdf(COMMENT.format("&a9;"), BOMB), "application/rdf+xml"),
    "external entity": (
        rdf(COMMENT.format("&e;"), "<!DOCTYPE x [<!ENTITY e SYSTEM 'file:///etc/passwd'>]>"),
        "application/rdf+xml",
    ),
    "remote context": (b'{"@context": "http://127.0.0.1:9/x", "@id": "urn:x"}', "application/ld+json"),
    "xml sent as turtle": (rdf(""), "text/turtle"),
    "entity bomb sent as turtle": (rdf(COMMENT.format("&a9;"), BOMB), "text/turtle"),
    "turtle sent as json": (b"scene:x a sk:Robot .", "application/json"),
    "no type": (b"scene:x a sk:Robot .", ""),
    "a form": (b"name=kitting", "application/x-www-form-urlencoded"),
    "text": (b'{"name": "kitting"}', "text/plain"),
    "many brackets": (b"scene:x sk:on " + b"[ sk:on " * 20_000, "text/turtle"),
    "many lists": (b"scene:x sk:on " + b"( " * 20_000, "text/turtle"),
    "two byte order marks": ("\ufeff\ufeffscene:x a sk:Robot .".encode(), "text/turtle"),
}


@pytest.mark.parametrize("how", UPLOADS)
def test_a_harmful_upload_is_refused_at_once_and_the_old_scene_stays(api: httpx2.Client, how: str) -> None:
    content, type_ = UPLOADS[how]
    before = api.get("/scene.ttl").text
    headers = ANYHOW | ({"Content-Type": type_} if type_ else {})

    answer = api.put("/scene", content=content, headers=headers)

    assert answer.status_code in (400, 413, 415, 422), answer.text[:300]
    assert "root:" not in answer.text
    assert api.get("/scene.ttl").text == before


# ------------------------------------------------------------------ case 11: worlds that make no sense


def test_no_edit_creates_a_cycle_of_places_of_any_length(api: httpx2.Client) -> None:
    pallets = []
    for number in range(5):
        new = {
            "class": "kitting:Pallet",
            "placement": {"relation": "sk:on", "place": pallets[-1] if number else "floor"},
        }
        pallets.append(api.post("/elements", json=new).raise_for_status().json()["id"])
    circle = {"placement": {"relation": "sk:on", "place": pallets[-1]}}

    refused = api.patch(f"/elements/{pallets[0]}", json=circle, headers=ANYHOW)
    at_once = api.post(
        "/world/transactions",
        json={
            "reason": "a circle",
            "operations": [
                {"op": "place", "element": one, "relation": "sk:on", "place": other}
                for one, other in zip(pallets, pallets[1:] + pallets[:1], strict=True)
            ],
        },
        headers=ANYHOW,
    )

    assert [one.json()["code"] for one in (refused, at_once)] == ["WorldRefused"] * 2, (refused.text, at_once.text)
    assert api.get("/tree", params={"depth": 20}).status_code == 200
    assert api.get(f"/elements/{pallets[-1]}").json()["placement"]["place"] == pallets[-2]


@pytest.mark.parametrize("value", ["NaN", "Infinity", "-Infinity", "1e309", "1e308"])
def test_an_invalid_pose_is_refused_in_every_request_that_takes_one(api: httpx2.Client, value: str) -> None:
    body = f'{{"properties": {{"sk:pose": {{"position": [{value}, 0, 0], "orientation": [0, 0, 0, 1]}}}}}}'
    before = api.get("/elements/rack_1").json()

    edit = api.patch("/elements/rack_1", content=body, headers={**ANYHOW, "Content-Type": "application/json"})
    text = api.get("/scene.ttl").text.replace("1.5 0 0 0 0 0", f"{value} 0 0 0 0 0")
    text = text.replace('"1.5 0 0 0 0 0 1"', f'"{value} 0 0 0 0 0 1"')
    upload = api.put("/scene", content=text.encode(), headers=TURTLE)

    assert edit.status_code in (400, 422), edit.text
    assert upload.status_code == 422 or value not in text
    assert api.get("/elements/rack_1").json()["properties"]["sk:pose"] == before["properties"]["sk:pose"]


# ------------------------------------------------------------------ case 13: files


@pytest.mark.parametrize("name", ["CON", "nul", "con", "aux.ttl", "../../x", "a\\b", "x" * 300, ".", "..", "Kitting"])
def test_a_scene_name_with_special_meaning_to_the_file_system_writes_nothing_outside_its_folder(
    served: Served, api: httpx2.Client, name: str
) -> None:
    before = {
        path
        for path in served.services.station.data.rglob("*")
        if path.parent.name != "scenes" and "db" not in path.name
    }

    answer = api.post("/scenes", json={"name": name})

    after = files_beside_scenes(served.services.station.data)
    assert answer.status_code in (201, 400, 422)
    assert after <= before | {served.services.station.data / "scenes"}
    if answer.status_code == 201:  # then it is a plain file
        assert (served.services.station.data / "scenes" / f"{name}.ttl").is_file()


def files_beside_scenes(data: Path) -> set[Path]:
    """Returns what is in a data directory, without what it writes while it runs, and beside it."""
    beside = set(data.parent.glob("*.ttl")) | set(data.parent.glob("x*"))
    return beside | {one for one in data.rglob("*") if one.parent.name != "scenes" and ".db" not in one.name}


def test_scene_names_that_differ_only_in_case_never_make_two_scenes(api: httpx2.Client) -> None:
    assert api.post("/scenes", json={"name": "cased"}).status_code == 201
    assert api.post("/scenes", json={"name": "Cased"}).status_code == 422
    assert api.get("/scenes/CASED").status_code in (404, 422)


def test_a_scene_that_does_not_fit_on_the_disk_is_reported_and_the_old_one_stays(
    served: Served, api: httpx2.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = api.post("/scenes", json={"name": "kept"})
    file = served.services.station.data / "scenes" / "kept.ttl"
    before, files = file.read_bytes(), sorted(file.parent.iterdir())
    api.patch("/elements/rack_1", json={"label": "changed"}, headers=ANYHOW).raise_for_status()

    def full(*_args: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as disk:
        disk.setattr(os, "fsync", full)
        answer = api.post("/scenes", json={"name": "kept"}, headers={"If-Match": seen.headers["etag"]})

    assert (answer.status_code, answer.json()["code"]) == (507, "NotSaved")
    assert file.read_bytes() == before
    assert sorted(file.parent.iterdir()) == files
