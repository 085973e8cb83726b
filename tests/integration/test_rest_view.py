"""The world as it is seen, over REST."""

from __future__ import annotations

from collections.abc import Iterator

import httpx2
import pytest
from support.serving import Served, serving

from skiros_py.client import Client

MANY = 2_000


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as running:
        yield running


@pytest.fixture
def api(served: Served) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=f"{served.url}/api/v1") as client:
        yield client


def test_the_view_contains_every_visible_element_with_its_shape(api: httpx2.Client) -> None:
    view = api.get("/view").json()

    told = {element["id"]: element for element in view["elements"]}
    assert told["pallet_a"]["class"] == told["pallet_a"]["shape"] == "kitting:Pallet"
    assert view["shapes"]["kitting:Pallet"][0]["size"] == [0.6, 0.8, 0.45]
    assert told["robot_1"]["pose"]["position"][:2] == pytest.approx([0.0, 0.0], abs=0.5)
    assert all(element["shape"] in view["shapes"] for element in view["elements"] if element["shape"])


def test_an_unchanged_view_is_answered_with_304(api: httpx2.Client) -> None:
    first = api.get("/view")
    known = {"If-None-Match": f'W/"0", {first.headers["etag"]}'}

    again = api.get("/view", headers=known)
    assert (again.status_code, again.content, again.headers["etag"]) == (304, b"", first.headers["etag"])

    edit = [{"op": "set", "element": "pallet_b", "property": "rdfs:label", "value": "another"}]
    written = api.post("/world/transactions", json={"reason": "try", "operations": edit}, headers={"If-Match": "*"})
    assert written.is_success, written.text
    later = api.get("/view", headers=known)
    assert later.status_code == 200
    assert later.json()["version"] == written.json()["version"] > first.json()["version"]


def test_a_page_fetches_only_elements_named_in_events(served: Served) -> None:
    with Client(served.url) as client:
        view = client.world.view(["kit_1_a", "never_there"])

    assert [element.id for element in view.elements] == ["kit_1_a"]
    assert view.gone == ("never_there",)


def test_an_invalid_view_request_is_refused_with_a_reason(api: httpx2.Client) -> None:
    answers = [api.get("/view", params={"elements": "kit_1"}), api.get("/view", params={"element": ["x"] * 101})]

    assert [answer.status_code for answer in answers] == [422, 422]
    assert "Did you mean 'element'" in answers[0].json()["detail"]


def test_the_view_contains_all_of_two_thousand_added_objects(api: httpx2.Client) -> None:
    before = len(api.get("/view").json()["elements"])
    operations = [
        {
            "op": "add",
            "class": "kitting:Pallet",
            "label": f"pallet {number}",
            "properties": {"sk:pose": {"position": [number % 50, number // 50, 0], "orientation": [0, 0, 0, 1]}},
            "placement": {"relation": "sk:on", "place": "floor"},
        }
        for number in range(MANY)
    ]
    for start in range(0, MANY, 500):
        body = {"reason": "many", "operations": operations[start : start + 500]}
        answer = api.post("/world/transactions", json=body)
        assert answer.is_success, answer.text

    view = api.get("/view").json()

    assert len(view["elements"]) == before + MANY
    assert len(view["shapes"]) < 20
