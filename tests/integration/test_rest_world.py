"""The world over REST: a real server with the pretending robot; what is written, by whom, and what is refused."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any
from urllib.parse import quote

import httpx2
import pytest
import rdflib
from hypothesis import given, settings
from hypothesis import strategies as st
from support.serving import Served, serving

from skiros_py.api.queries import AskAnswer, Query
from skiros_py.api.transactions import SetOperation, TransactionOrder
from skiros_py.api.world import ElementPatch, GivenPose, LockOrder, NewElement, Placement
from skiros_py.client.client import Client
from skiros_py.client.request import ProblemError
from skiros_py.client.topics import Elements, Learned, Locks, Ontology, Queries, World
from skiros_py.world.change import Writer
from skiros_py.world.journal.journal import Journal
from skiros_py.world.vocabulary import APPLIES_TO, GRASP_WIDTH, TAUGHT_GRASP

IN_PALLET = {"relation": "sk:in", "place": "pallet_a"}
ANYHOW = {"If-Match": "*"}


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as served:
        yield served


@pytest.fixture(scope="module")
def api(served: Served) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=f"{served.url}/api/v1", timeout=30.0) as client:
        yield client


def get(api: httpx2.Client, path: str, **query: Any) -> Any:
    response = api.get(path, params=query)
    assert response.status_code == 200, response.text
    return response.json()


def add(api: httpx2.Client, **more: Any) -> dict[str, Any]:
    response = api.post("/elements", json={"class": "kitting:Starter", "placement": IN_PALLET, **more})
    assert response.status_code == 201, response.text
    told: dict[str, Any] = response.json()
    return told


def problem(response: httpx2.Response, status: int) -> dict[str, Any]:
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == "application/problem+json"
    told: dict[str, Any] = response.json()
    return told


# ------------------------------------------------------------------ looking


def test_elements_of_a_class_are_listed_page_by_page(api: httpx2.Client) -> None:
    everything = get(api, "/elements", limit=1000)["items"]
    found, cursor = [], None
    while True:
        page = get(api, "/elements", limit=7, **({"cursor": cursor} if cursor else {}))
        found += page["items"]
        cursor = page["next"]
        if cursor is None:
            break

    assert found == everything
    assert {"pallet_a", "robot_1", "kit_1_a"} <= {one["id"] for one in found}


def test_elements_can_be_searched_by_class_label_text_and_place(api: httpx2.Client) -> None:
    def ids(**query: Any) -> set[str]:
        return {one["id"] for one in get(api, "/elements", **query)["items"]}

    assert "kit_1" in ids(**{"class": "kitting:Kit"})
    assert ids(label="pallet A") == {"pallet_a"}
    assert ids(text="COMPARTMENT", place="kit_1") == set()
    assert "alternator_1" in ids(text="altern", place="pallet_a")
    assert "kitting:standard_kit" in ids(abstract=True, **{"class": "kitting:Kit"})


def test_an_element_is_returned_with_its_values_their_origin_and_its_place(api: httpx2.Client) -> None:
    compartment = get(api, "/elements/kit_1_a")
    starter = get(api, "/elements/starter_1")

    pose = compartment["properties"]["sk:pose"]
    assert (pose["origin"], pose["value"]["frame"]) == ("own", "kit_1")
    assert compartment["owner"] == "kit_1"
    assert compartment["map_pose"]["position"] == pytest.approx([-1.477, -0.073, 0.506])
    assert starter["properties"]["sk:mass"] == {"value": 0.8, "origin": "class", "taught_by": None}
    assert {"subject": "starter_1", "relation": "sk:in", "object": "pallet_a", "family": "placement"} in starter[
        "relations"
    ]
    assert starter["computed"] == []


def test_computed_relations_are_evaluated_on_request(api: httpx2.Client) -> None:
    some = get(api, "/elements/starter_1", computed=["sk:graspableBy"])["computed"]
    every = get(api, "/elements/starter_1", computed=["all"])["computed"]

    assert [(one["relation"], one["object"]) for one in some] == [("sk:graspableBy", "gripper_1")]
    assert some[0] in every
    assert len(every) > len(some)
    assert "stated, not computed" in problem(api.get("/elements/starter_1?computed=sk:in"), 422)["detail"]
    assert get(api, "/elements/gripper_1/relations", relation="sk:graspableBy")["items"]


def test_taught_values_are_marked_as_taught(served: Served, api: httpx2.Client) -> None:
    with served.services.station.session.world.transaction("teach", "shown by hand") as tx:
        lesson = tx.add(TAUGHT_GRASP, properties={APPLIES_TO: "kitting:RelayBox", GRASP_WIDTH: 0.031}, learned=True)
    pump = add(api, **{"class": "kitting:RelayBox"})

    assert pump["properties"]["sk:graspWidth"] == {"value": 0.031, "origin": "taught", "taught_by": lesson}


def test_an_id_with_a_colon_can_be_used_in_a_path(api: httpx2.Client) -> None:
    quoted, plain = api.get("/elements/kitting%3Astandard_kit"), api.get("/elements/kitting:standard_kit")

    assert quoted.json() == plain.json()
    assert plain.json()["abstract"] is True


def test_an_unknown_element_is_answered_with_404_and_the_nearest_id(api: httpx2.Client) -> None:
    told = problem(api.get("/elements/startr_1"), 404)

    assert told["nearest"] == "starter_1"


def test_the_world_tree_leads_from_the_floor_to_the_compartments(api: httpx2.Client) -> None:
    def names(node: dict[str, Any]) -> Iterator[tuple[str, str]]:
        for child in node["children"]:
            yield child["id"], node["id"]
            yield from names(child)

    tree = dict(names(get(api, "/tree", depth=20)))

    assert (tree["floor"], tree["pallet_a"], tree["kit_1"], tree["kit_1_a"]) == ("", "floor", "kit_table", "kit_1")
    assert (tree["arm_1"], tree["alternator_1"]) == ("robot_1", "pallet_a")


def test_large_levels_of_the_tree_are_read_in_pages(api: httpx2.Client) -> None:
    found: list[str] = []
    cursor: str | None = ""
    while cursor is not None:
        node = get(api, "/tree", root="pallet_b", depth=1, limit=2, cursor=cursor)
        assert len(node["children"]) <= 2
        found += [child["id"] for child in node["children"]]
        cursor = node["next"]

    assert len(found) == node["children_total"]
    assert found == sorted(set(found))


# ------------------------------------------------------------------ writing


def test_an_element_is_added_with_values_place_and_frame_in_one_request(api: httpx2.Client) -> None:
    pose = {"position": [0.1, 0.0, 0.02], "orientation": [0.0, 0.0, 0.0, 1.0], "frame": "pallet_a"}
    response = api.post(
        "/elements",
        json={
            "class": "kitting:Starter",
            "label": "spare",
            "placement": IN_PALLET,
            "properties": {"sk:mass": 1, "sk:pose": pose},
            "reason": "delivered",
        },
    )
    told = response.json()

    assert response.status_code == 201
    assert get(api, response.headers["location"].removeprefix("/api/v1")) == told
    assert response.headers["etag"] == f'"{told["version"]}"'
    assert told["properties"]["sk:mass"] == {"value": 1.0, "origin": "own", "taught_by": None}
    assert told["properties"]["sk:pose"]["value"] == pose
    assert told["map_pose"]["position"] == pytest.approx([5.1, 1.6, 0.02])
    change = get(api, f"/elements/{told['id']}/history")["items"][0]
    assert (change["author"], change["writer"], change["reason"]) == ("local", "person", "delivered")


def test_a_kit_can_be_added_as_a_copy_with_its_compartments(api: httpx2.Client) -> None:
    place = {"relation": "sk:on", "place": "floor"}
    by_the_book = api.post("/elements", json={"like": "kitting:standard_kit", "placement": place}).json()
    twin = api.post("/elements", json={"like": by_the_book["id"], "label": "twin", "placement": place}).json()

    for kit in (by_the_book, twin):
        pieces = [one["object"] for one in kit["relations"] if one["relation"] == "sk:hasA"]
        assert len(pieces) == 4
        assert get(api, f"/elements/{pieces[0]}")["owner"] == kit["id"]
    assert twin["label"] == "twin"


def test_label_values_and_place_are_changed_in_one_transaction(api: httpx2.Client) -> None:
    one = add(api)
    patch = {
        "label": "dented",
        "properties": {"sk:mass": 0.5},
        "placement": {"relation": "sk:in", "place": "pallet_b"},
        "reason": "weighed",
    }
    response = api.patch(f"/elements/{one['id']}", json=patch, headers={"If-Match": f'"{one["version"]}"'})
    told = response.json()

    assert (told["label"], told["placement"]["place"]) == ("dented", "pallet_b")
    assert told["version"] == get(api, "/world")["version"] == one["version"] + 1
    taken_away = api.patch(f"/elements/{one['id']}", json={"properties": {"sk:mass": None}}, headers=ANYHOW).json()
    assert taken_away["properties"]["sk:mass"]["origin"] == "class"


def test_an_edit_without_the_current_version_changes_nothing(api: httpx2.Client) -> None:
    one = add(api)
    path, seen = f"/elements/{one['id']}", {"If-Match": f'"{one["version"]}"'}
    assert api.patch(path, json={"label": "first"}, headers=seen).status_code == 200

    blind, late = api.patch(path, json={"label": "blind"}), api.patch(path, json={"label": "late"}, headers=seen)

    assert problem(blind, 428)["code"] == "VersionMissing"
    assert problem(late, 412)["code"] == "StaleVersion"
    assert problem(api.delete(path, headers=seen), 412)
    assert get(api, path)["label"] == "first"


def test_of_many_edits_with_the_same_version_exactly_one_succeeds(api: httpx2.Client) -> None:
    one = add(api)

    def patch(number: int) -> int:
        seen = {"If-Match": f'"{one["version"]}"'}
        return api.patch(f"/elements/{one['id']}", json={"label": f"by {number}"}, headers=seen).status_code

    with ThreadPoolExecutor(20) as pool:
        statuses = sorted(pool.map(patch, range(20)))

    assert statuses == [200] + [412] * 19


def test_a_relation_can_be_stated_and_removed(api: httpx2.Client) -> None:
    path = "/elements/starter_1/relations/sk:poseFrame/pallet_a"
    stated = api.put(path, headers=ANYHOW)
    relations = get(api, "/elements/starter_1")["relations"]
    gone = api.delete(path, headers={"If-Match": stated.headers["etag"]})

    assert "sk:poseFrame" in {one["relation"] for one in relations}
    assert gone.status_code == 200
    assert "sk:poseFrame" not in {one["relation"] for one in get(api, "/elements/starter_1")["relations"]}


def test_placing_an_element_replaces_its_previous_placement(api: httpx2.Client) -> None:
    one = add(api)
    path = f"/elements/{one['id']}/relations/sk:in"
    moved = api.put(f"{path}/pallet_b", headers={"If-Match": f'"{one["version"]}"'})

    assert moved.json()["change"]["edits_total"] == 1
    assert get(api, f"/elements/{one['id']}")["placement"] == {"relation": "sk:in", "place": "pallet_b"}
    assert "place it elsewhere" in problem(api.delete(f"{path}/pallet_b", headers=ANYHOW), 422)["detail"]


def test_a_removed_element_is_gone_but_its_history_stays(api: httpx2.Client) -> None:
    one = add(api)
    response = api.delete(f"/elements/{one['id']}", headers={"If-Match": f'"{one["version"]}"'})

    assert response.json()["change"]["reason"] == f"removes {one['id']}"
    assert api.get(f"/elements/{one['id']}").status_code == 404
    history = get(api, f"/elements/{one['id']}/history")
    assert [change["reason"] for change in history["items"]] == [f"removes {one['id']}", "adds a kitting:Starter"]
    assert history["items"][0]["texts"][f"removes {one['id']}"]["template"] == "removes {element}"
    assert (
        "never used again"
        in problem(api.post("/elements", json={"class": "kitting:Starter", "id": one["id"]}), 422)["detail"]
    )


# ------------------------------------------------------------------ transactions


def test_a_transaction_is_one_change(api: httpx2.Client) -> None:
    before = get(api, "/world")["version"]
    operations = [
        {
            "op": "add",
            "ref": "kit",
            "like": "kitting:standard_kit",
            "placement": {"relation": "sk:on", "place": "floor"},
        },
        {"op": "add", "ref": "part", "class": "kitting:Starter", "placement": {"relation": "sk:in", "place": "$kit"}},
        {"op": "set", "element": "$part", "property": "rdfs:label", "value": "first part"},
        {"op": "place", "element": "$part", "relation": "sk:in", "place": "pallet_a"},
        {"op": "relate", "subject": "$part", "relation": "sk:poseFrame", "object": "pallet_a"},
        {"op": "unrelate", "subject": "$part", "relation": "sk:poseFrame", "object": "pallet_a"},
        {"op": "remove", "element": "$kit"},
    ]
    response = api.post(
        "/world/transactions",
        json={"reason": "all at once", "operations": operations},
        headers={"If-Match": f'"{before}"'},
    )
    told = response.json()

    assert response.status_code == 200, response.text
    assert told["version"] == before + 1
    part = get(api, f"/elements/{told['ids']['part']}")
    assert (part["label"], part["placement"]["place"]) == ("first part", "pallet_a")
    assert api.get(f"/elements/{told['ids']['kit']}").status_code == 404


def test_a_refused_transaction_changes_nothing_and_lists_all_faults(api: httpx2.Client) -> None:
    before = get(api, "/world")["version"]
    operations = [
        {"op": "add", "class": "kitting:Starter", "placement": IN_PALLET},
        {"op": "set", "element": "starter_1", "property": "sk:mass", "value": "heavy"},
        {"op": "place", "element": "starter_1", "relation": "sk:in", "place": "nowhere"},
        {"op": "add", "class": "kitting:Startr"},
    ]
    order = {"reason": "all wrong", "expects": {"starter_1": get(api, "/elements/starter_1")["version"]}}
    told = problem(api.post("/world/transactions", json={**order, "operations": operations}), 422)

    assert all(said in told["detail"] for said in ("sk:mass of starter_1", "'nowhere'", "'kitting:Startr'"))
    assert get(api, "/world")["version"] == before


def test_a_transaction_on_existing_elements_needs_their_versions(api: httpx2.Client) -> None:
    remove = {"reason": "tidy", "operations": [{"op": "remove", "element": "starter_1"}]}

    assert problem(api.post("/world/transactions", json=remove), 428)["code"] == "VersionMissing"
    assert problem(api.post("/world/transactions", json={**remove, "expects": {"starter_1": 0}}), 412)
    assert problem(api.post("/world/transactions", json=remove, headers={"If-Match": '"0"'}), 412)
    assert problem(api.post("/world/transactions", json={**remove, "expects": {"nobody": 1}}), 422)
    assert api.get("/elements/starter_1").status_code == 200


def test_an_undefined_reference_in_a_transaction_is_refused(api: httpx2.Client) -> None:
    operations = [{"op": "add", "class": "kitting:Starter", "placement": {"relation": "sk:in", "place": "$box"}}]
    told = problem(api.post("/world/transactions", json={"reason": "why", "operations": operations}), 422)

    assert "nothing was added as '$box'" in told["detail"]


# ------------------------------------------------------------------ what can never be (case 11)


@pytest.mark.parametrize(
    "value",
    [
        '{"position": [NaN, 0, 0]}',
        '{"position": [Infinity, 0, 0]}',
        '{"position": [1e308, 0, 0]}',
        '{"position": [1e999, 0, 0]}',
        '{"position": [0, 0, 0], "orientation": [0, 0, 0, 0]}',
        '{"position": [0, 0, 0], "orientation": [1e200, 0, 0, 1e200]}',
        '{"position": [0, 0]}',
        '{"position": ["0", 0, 0]}',
        '"0 0 0 0 0 0"',
        "[0, 0, 0]",
        "17",
        "1" * 5000,
    ],
)
def test_an_invalid_pose_is_refused(api: httpx2.Client, value: str) -> None:
    body = f'{{"properties": {{"sk:pose": {value}}}}}'
    response = api.patch("/elements/pallet_a", content=body, headers={**ANYHOW, "Content-Type": "application/json"})

    assert problem(response, response.status_code)["status"] in (400, 422)


def test_a_pose_without_a_frame_keeps_the_current_frame(api: httpx2.Client) -> None:
    one = add(api, properties={"sk:pose": {"position": [0.1, 0.0, 0.0], "frame": "pallet_a"}})
    path = f"/elements/{one['id']}"

    def write(pose: dict[str, Any]) -> Any:
        return api.patch(path, json={"properties": {"sk:pose": pose}}, headers=ANYHOW).json()["properties"]["sk:pose"]

    assert write({"position": [0.2, 0.0, 0.0]})["value"]["frame"] == "pallet_a"
    assert "frame" not in write({"position": [0.2, 0.0, 0.0], "frame": None})["value"]
    refused = api.patch(
        path, json={"properties": {"sk:graspPose": {"position": [0, 0, 0], "frame": "floor"}}}, headers=ANYHOW
    )
    assert "leave out 'frame'" in problem(refused, 422)["detail"]


def test_placing_elements_in_a_cycle_is_refused(api: httpx2.Client) -> None:
    pallet = {"class": "kitting:Pallet", "placement": {"relation": "sk:on", "place": "floor"}}
    a, b = add(api, **pallet), add(api, **pallet)
    assert api.put(f"/elements/{a['id']}/relations/sk:on/{b['id']}", headers=ANYHOW).status_code == 200

    told = problem(api.put(f"/elements/{b['id']}/relations/sk:on/{a['id']}", headers=ANYHOW), 422)

    assert "inside itself" in told["detail"]


@pytest.mark.parametrize("name", ["kitting:standard_kit", "kitting:Starter", "sk:in"])
def test_no_request_changes_the_ontology(api: httpx2.Client, name: str) -> None:
    operations = [{"op": "set", "element": name, "property": "rdfs:label", "value": "mine"}]
    order = {"reason": "why not", "operations": operations}
    told = problem(api.post("/world/transactions", json=order, headers=ANYHOW), 422)

    assert "never changed at run time" in told["detail"]


# ------------------------------------------------------------------ history and undo


def test_changes_are_read_page_by_page_in_both_directions(api: httpx2.Client) -> None:
    add(api), add(api)

    def numbers(**query: Any) -> list[int]:
        found, cursor = [], None
        while True:
            page = get(api, "/world/changes", limit=3, **query, **({"cursor": cursor} if cursor else {}))
            found += [change["number"] for change in page["items"]]
            cursor = page["next"]
            if cursor is None:
                return found

    version = get(api, "/world")["version"]
    assert numbers() == list(range(1, version + 1))
    assert numbers(newest_first=True) == list(range(version, 0, -1))
    assert numbers(since=version - 1) == [version]
    assert numbers(since=version) == []


def test_a_large_change_is_read_in_pages_of_edits(api: httpx2.Client) -> None:
    operations = [{"op": "add", "class": "kitting:Starter", "placement": IN_PALLET} for _ in range(80)]
    number = api.post("/world/transactions", json={"reason": "many", "operations": operations}).json()["version"]
    listed = get(api, "/world/changes", since=number - 1)["items"][0]
    edits, cursor = [], None
    while True:
        part = get(api, f"/world/changes/{number}", limit=50, **({"cursor": cursor} if cursor else {}))
        edits += part["edits"]
        cursor = part["next"]
        if cursor is None:
            break

    assert (len(listed["edits"]), listed["edits_total"], listed["next"]) == (100, 160, "100")
    assert len(edits) == 160
    assert edits[:100] == listed["edits"]
    assert problem(api.get("/world/changes/999999"), 404)


def test_undo_reverts_the_edits_of_people_one_by_one(api: httpx2.Client) -> None:
    first, second = add(api), add(api)
    told = get(api, "/world")["undoable"]
    stale = api.post("/world/undo", json={"change": told["number"] - 1})
    undone = api.post("/world/undo", json={"change": told["number"]}).json()
    api.post("/world/undo")

    assert problem(stale, 412)
    assert undone["undoes"] == told["number"] == second["version"]
    assert api.get(f"/elements/{first['id']}").status_code == api.get(f"/elements/{second['id']}").status_code == 404


def test_a_change_on_which_others_depend_is_not_undone(served: Served, api: httpx2.Client) -> None:
    one = add(api)
    with served.services.station.session.world.transaction("look", "seen there", writer=Writer.SKILL) as tx:
        tx.place(one["id"], "sk:in", "pallet_b")

    told = problem(api.post("/world/undo"), 409)

    assert told["code"] == "CannotUndo"
    assert "look" in told["detail"]
    api.delete(f"/elements/{one['id']}", headers=ANYHOW)


# ------------------------------------------------------------------ locks


def test_a_locked_element_can_be_edited_only_by_its_owner(api: httpx2.Client) -> None:
    def as_(user: str) -> dict[str, str]:
        return {**ANYHOW, "X-Skiros-User": user}

    locked = api.post("/locks", json={"elements": ["kit_1"], "seconds": 60}, headers=as_("ann"))
    others = api.patch("/elements/kit_1_a", json={"label": "mine"}, headers=as_("bob"))
    own = api.patch("/elements/kit_1_a", json={"label": "compartment A"}, headers=as_("ann"))
    again = api.post("/locks", json={"elements": ["floor", "kit_1"]}, headers=as_("bob"))

    assert locked.status_code == 201
    told = problem(others, 423)
    assert [(lock["element"], lock["owner"]) for lock in told["locks"]] == [("kit_1", "ann")]
    assert told["locks"][0]["until"] > "2020"
    assert own.status_code == 200
    assert problem(again, 423)["locks"][0]["owner"] == "ann"
    assert [lock["element"] for lock in get(api, "/locks")["items"]] == ["kit_1"]
    assert api.request("DELETE", "/locks", params={"elements": "kit_1"}, headers=as_("ann")).json() == {
        "items": [],
        "next": None,
    }


@pytest.mark.parametrize("order", [{"elements": ["nobody"]}, {"elements": ["kit_1"], "seconds": 1e9}, {"elements": []}])
def test_an_invalid_lock_is_refused(api: httpx2.Client, order: dict[str, Any]) -> None:
    assert problem(api.post("/locks", json=order), 422)


# ------------------------------------------------------------------ what was learned


def test_learned_concepts_can_be_listed_exported_and_forgotten(served: Served, api: httpx2.Client) -> None:
    with served.services.station.session.world.transaction("teach", "shown by hand") as tx:
        lesson = tx.add(TAUGHT_GRASP, properties={APPLIES_TO: "kitting:Starter", GRASP_WIDTH: 0.04}, learned=True)
    told = {one["id"]: one for one in get(api, "/learned")["items"]}[lesson]
    turtle = api.get("/learned.ttl")

    assert (told["about"], told["properties"]["sk:graspWidth"]) == ("kitting:Starter", 0.04)
    assert turtle.headers["content-type"].startswith("text/turtle")
    assert lesson in turtle.text
    assert problem(api.delete(f"/learned/{lesson}"), 428)
    assert problem(api.delete("/learned/starter_1", headers=ANYHOW), 404)
    assert api.delete(f"/learned/{lesson}", headers={"If-Match": f'"{told["version"]}"'}).status_code == 200
    assert lesson not in {one["id"] for one in get(api, "/learned")["items"]}


def test_learned_concepts_are_added_edited_and_imported_and_each_change_can_be_undone(api: httpx2.Client) -> None:
    new = {"class": TAUGHT_GRASP, "properties": {APPLIES_TO: "kitting:RelayBox", GRASP_WIDTH: 0.03}}
    added = api.post("/learned", json=new)
    lesson = added.json()["ids"]["new"]
    patch = {"label": "from the side", "properties": {GRASP_WIDTH: 0.02}}
    edited = api.patch(f"/learned/{lesson}", json=patch, headers=ANYHOW)
    text = api.get("/learned.ttl").text
    api.delete(f"/learned/{lesson}", headers=ANYHOW).raise_for_status()
    graph = rdflib.Graph().parse(data=text, format="turtle")
    kinds = {"application/n-triples": "nt", "application/ld+json": "json-ld", "application/rdf+xml": "xml"}
    imported = [
        api.post("/learned/import", content=graph.serialize(format=form), headers={"Content-Type": kind})
        for kind, form in kinds.items()
    ]

    assert (added.status_code, edited.status_code) == (201, 200)
    assert added.headers["Location"].endswith("/elements/" + lesson.replace(":", "%3A"))
    assert edited.json()["change"]["author"] == added.json()["change"]["author"]
    assert imported[0].json()["change"]["writer"] == "person"
    assert [one.json()["change"] for one in imported[1:]] == [None, None]
    assert api.get("/learned.ttl").text == text
    api.post("/world/undo").raise_for_status()
    assert lesson not in api.get("/learned.ttl").text


def test_what_no_learned_concept_can_be_is_refused_with_a_reason(api: httpx2.Client) -> None:
    turtle = {"Content-Type": "text/turtle"}
    foreign = api.post(
        "/learned/import", content=b"\n<http://example.org/a> a <http://example.org/b> .", headers=turtle
    )
    other = api.post("/learned/import", content=b"x", headers={"Content-Type": "text/plain"})
    named = api.post("/learned", json={"class": "kitting:Starter", "id": "mug_1"})
    placed = {"relation": "sk:in", "place": "pallet_a"}
    scene = api.post("/learned", json={"class": "kitting:Starter", "placement": placed})

    assert problem(foreign, 422)["line"] == 2
    assert "may speak of learned: individuals only" in foreign.json()["detail"]
    assert "/tmp" not in foreign.text
    assert "application/ld+json" in problem(other, 415)["detail"]
    assert "begins with 'learned:'" in problem(named, 422)["detail"]
    assert "what is learned outlives the scene" in problem(scene, 422)["detail"]
    assert problem(api.patch("/learned/starter_1", json={"label": "x"}, headers=ANYHOW), 404)


def test_a_different_concept_is_replaced_only_on_request(api: httpx2.Client) -> None:
    new = {"like": "starter_1", "id": None, "label": "a starter", "reason": "seen"}
    concept = api.post("/learned", json=new).json()["ids"]["new"]
    before = api.get("/learned.ttl").text
    api.patch(f"/learned/{concept}", json={"label": "dented"}, headers=ANYHOW).raise_for_status()
    body = {"content": before.encode(), "headers": {"Content-Type": "text/turtle"}}

    assert f"{concept}: known already, and different" in problem(api.post("/learned/import", **body), 422)["detail"]
    assert api.post("/learned/import", params={"replace": True}, **body).status_code == 200
    assert api.get("/learned.ttl").text == before


# ------------------------------------------------------------------ the ontology


def test_classes_are_listed_as_a_tree_with_their_instance_counts(api: httpx2.Client) -> None:
    tree = get(api, "/ontology/classes", root="kitting:Part")
    shallow = get(api, "/ontology/classes", root="kitting:Part", depth=0)

    assert "kitting:Starter" in {child["name"] for child in tree["children"]}
    assert tree["instances"] == sum(child["instances"] for child in tree["children"])
    assert (shallow["children"], shallow["children_total"]) == ([], len(tree["children"]))
    assert problem(api.get("/ontology/classes?root=kitting:Prat"), 404)["nearest"] == "kitting:Part"


def test_a_class_is_described_with_its_properties_and_the_skills_and_conditions_that_use_it(api: httpx2.Client) -> None:
    told = get(api, "/ontology/classes/kitting:Starter")
    mass = next(one for one in told["properties"] if one["name"] == "sk:mass")

    assert (mass["datatype"], mass["unit"], mass["value"]) == ("xsd:decimal", "kg", 0.8)
    assert told["ancestors"][:2] == ["kitting:Starter", "kitting:Part"]
    assert "pick" in {use["name"] for use in told["skills"]}
    assert "InKit" in {use["name"] for use in told["conditions"]}
    assert "starter_1" in told["some_instances"]
    assert "sk:in" in told["relations_from"]
    assert problem(api.get("/ontology/classes/nothing"), 404)


def test_relations_and_properties_are_listed_page_by_page(api: httpx2.Client) -> None:
    for what in ("relations", "properties"):
        whole = get(api, f"/ontology/{what}")["items"]
        first = get(api, f"/ontology/{what}", limit=5)
        rest = get(api, f"/ontology/{what}", cursor=first["next"])
        assert first["items"] + rest["items"] == whole
    placed = next(one for one in get(api, "/ontology/relations")["items"] if one["name"] == "sk:heldBy")
    assert (placed["family"], placed["place_end"], placed["objects"]) == ("placement", "object", [["sk:Gripper"]])


def test_the_offered_placements_are_exactly_those_that_a_write_accepts(api: httpx2.Client) -> None:
    one = add(api)
    told = get(api, "/ontology/placements", element=one["id"])
    tried = {}
    for option in told["options"]:
        for place in option["places"]:
            path = f"/elements/{one['id']}/relations/{option['relation']}/{place['id']}"
            tried[option["relation"], place["id"]] = api.put(path, headers=ANYHOW).status_code == 200

    assert ("sk:in", "pallet_b") in tried
    assert tried == {
        (option["relation"], place["id"]): place["fits"] for option in told["options"] for place in option["places"]
    }


def test_the_offered_placements_mark_places_that_are_too_small(api: httpx2.Client) -> None:
    told = get(api, "/ontology/placements", **{"class": "kitting:Kit"}, relation="sk:in")
    places = {place["id"]: place for place in told["options"][0]["places"]}

    assert not places["kit_1_a"]["fits"]
    assert "does not fit" in places["kit_1_a"]["why_not"]
    assert problem(api.get("/ontology/placements"), 422)
    assert problem(api.get("/ontology/placements?element=nobody"), 422)


@pytest.mark.parametrize(
    ("accepted", "language", "label"),
    [
        ("", "en", "starter"),
        ("en", "en", "starter"),
        ("de", "de", "Anlasser"),
        ("de-AT", "de", "Anlasser"),
        ("fr;q=0.9, de;q=0.8", "de", "Anlasser"),
        ("de;q=0.1, en-GB;q=0.7", "en", "starter"),
        ("fr", "en", "starter"),
        ("*", "en", "starter"),
        ("de;q=0, *;q=0.1", "en", "starter"),
        ("de;q=much,,;=\x00\xff*", "en", "starter"),
    ],
)
def test_terms_are_answered_in_the_best_accepted_language_that_the_ontology_has(
    api: httpx2.Client, accepted: str, language: str, label: str
) -> None:
    headers = {b"Accept-Language": accepted.replace("\0", "").encode("latin-1")}
    response = api.get("/ontology/classes/kitting:Starter", headers=headers)

    assert (response.json()["label"], response.headers["Content-Language"]) == (label, language)
    assert response.headers["Vary"] == "Accept-Language"


def test_every_route_with_terms_answers_in_the_language_of_the_request(api: httpx2.Client, served: Served) -> None:
    with Client(served.url) as client:
        ontology = client.ontology
        (held,) = (one for one in ontology.relations(language="de").items if one.name == "sk:heldBy")
        (pose,) = (one for one in ontology.properties(language="de").items if one.name == "sk:pose")
        kit = ontology.get("kitting:Kit", language="de")
        (place,) = ontology.placements(element="starter_1", relation="sk:in", language="de").options
        tree = ontology.classes("kitting:Part", language="de")

        assert (tree.label, tree.children[0].label) == ("Teil", "Lichtmaschine")
        assert (kit.label, kit.comment[:17]) == ("Kit", "Ein festes Tablet")
        assert next(one.label for one in kit.properties if one.name == "sk:mass") == "Masse"
        assert (held.label, held.comment) == ("gehalten von", "Der Greifer hält das Ding.")
        assert (pose.label, place.label) == ("Lage", "in")
        assert ontology.get("kitting:Starter").label == "starter"
        assert next(one.label for one in ontology.properties(language="tlh").items if one.name == "sk:pose") == "pose"


# ------------------------------------------------------------------ whatever is sent


@settings(max_examples=60, deadline=None)
@given(text=st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1, max_size=60))
def test_a_label_is_stored_as_text_whatever_it_contains(api: httpx2.Client, text: str) -> None:
    told = api.patch("/elements/kit_table", json={"label": text}, headers=ANYHOW).json()
    rows = api.post(
        "/queries",
        json={"query": "SELECT ?e { ?e rdfs:label $label }", "bindings": {"label": {"text": text}}},
    ).json()["rows"]

    assert told["label"] == text
    assert {"e": "kit_table"} in rows


@settings(max_examples=60, deadline=None)
@given(name=st.text(st.characters(codec="utf-8"), min_size=1, max_size=60))
def test_an_unusual_id_in_the_path_is_answered_with_404(api: httpx2.Client, name: str) -> None:
    quoted = quote(name, safe="").replace(".", "%2E")
    for response in (
        api.get(f"/elements/{quoted}"),
        api.patch(f"/elements/{quoted}", json={"label": "x"}, headers=ANYHOW),
        api.put(f"/elements/starter_1/relations/{quoted}/floor", headers=ANYHOW),
        api.get("/elements", params={"cursor": name, "text": name}),
        api.get("/world/changes", params={"cursor": name}),
        api.get("/tree", params={"root": name}),
        api.delete(f"/learned/{quoted}", headers=ANYHOW),
    ):
        assert response.status_code in (200, 400, 404, 422), response.text


def test_unpaired_surrogates_are_refused(api: httpx2.Client) -> None:
    half = '"\\ud800"'
    for body in (f'{{"label": {half}}}', f'{{"properties": {{"rdfs:comment": {half}}}}}', f'{{"reason": {half}}}'):
        headers = {**ANYHOW, "Content-Type": "application/json"}
        assert problem(api.patch("/elements/kit_table", content=body, headers=headers), 400)


def test_the_world_survives_a_restart_of_the_server(tmp_path: Path) -> None:
    with serving("kitting", tmp_path) as served, httpx2.Client(base_url=f"{served.url}/api/v1") as api:
        one = add(api, label="still here")
    with serving("kitting", tmp_path) as served, httpx2.Client(base_url=f"{served.url}/api/v1") as api:
        assert get(api, f"/elements/{one['id']}")["label"] == "still here"
        assert get(api, "/world")["undoable"]["number"] == one["version"]


def test_reading_compacted_changes_is_answered_with_that_reason(tmp_path: Path) -> None:
    with serving("kitting", tmp_path) as served, httpx2.Client(base_url=f"{served.url}/api/v1") as api:
        one = add(api)
        live = served.services.station.session.world
        assert isinstance(live.log, Journal)
        live.log.compact(live.snapshot(), keep=1)

        for path in ("/world/changes/1", "/world/changes?since=1"):
            assert problem(api.get(path), 410)["remembered_from"] == one["version"]
        assert [change["number"] for change in get(api, "/world/changes")["items"]] == [one["version"]]


def test_the_client_reads_and_edits_the_world(served: Served) -> None:
    with Client(served.url) as client:
        new = NewElement(class_="kitting:Starter", placement=Placement(relation="sk:in", place="pallet_a"))
        one = client.send(Elements.add(new))
        pose = GivenPose(position=(0.0, 0.1, 0.0), frame="pallet_a")
        patch = ElementPatch(label="by the client", properties={"sk:pose": pose})
        changed = client.send(Elements.edit(one.id, patch, version=one.version))
        page = client.send(Elements.list(label="by the client"))
        stated = client.send(Elements.relate(one.id, "sk:in", "pallet_b", version=changed.version))
        operation = SetOperation(op="set", element=one.id, property="rdfs:label", value="in a transaction")
        order = TransactionOrder(reason="all", operations=[operation])
        together = client.send(World.write(order, version=stated.version))
        undone = client.send(World.undo(together.version))
        gone = client.send(Elements.remove(one.id, reason="done"))

        assert changed.properties["sk:pose"].value["frame"] == "pallet_a"
        assert [found.id for found in page.items] == [one.id]
        assert client.send(Elements.get("starter_1", computed=["sk:graspableBy"])).computed
        assert client.send(Elements.relations("starter_1", relation="sk:in")).items
        assert client.send(Elements.history(one.id)).items[0].number == gone.version
        assert (undone.undoes, client.send(World.change(undone.number)).undoes) == (together.version,) * 2
        assert client.send(World.get()).version == gone.version
        assert client.send(World.changes(gone.version - 1)).items[0].reason == "done"
        assert client.send(World.tree("kit_1", depth=1)).children_total == 4
        assert client.send(Ontology.classes("kitting:Part", depth=1)).children
        assert client.send(Ontology.get("kitting:Kit")).instances >= 1
        assert client.send(Ontology.relations(limit=1)).next
        assert client.send(Ontology.properties(limit=1)).next
        assert client.send(Ontology.placements(element="starter_1", relation="sk:in")).options
        assert [lock.element for lock in client.send(Locks.lock(LockOrder(elements=["kit_1"]))).items] == ["kit_1"]
        assert [lock.owner for lock in client.send(Locks.list()).items] == ["local"]
        assert client.send(Locks.end(["kit_1"])).items == []
        assert client.send(Learned.list()).next is None
        assert "owl:Ontology" in client.send(Learned.export())
        answer = client.send(Queries.ask(Query(query="ASK { scene:kit_1 a kitting:Kit }")))
        assert answer == AskAnswer(form="ASK", answer=True)
        with pytest.raises(ProblemError, match="unknown element"):
            client.send(Elements.get("nobody"))
