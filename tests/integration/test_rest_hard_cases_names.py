"""Cases 5 and 9: names and labels that look like PDDL, goals, SPARQL or Turtle are names and labels, all the way."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import httpx2
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from support.serving import Served, serving

from .hard import ANYHOW, api_of, begin_anew, over

TURTLE = {**ANYHOW, "Content-Type": "text/turtle"}
ALIKE = {"starter_1": "and", "alternator_1": "AND", "compressor_1": "define", "relay_box_1": "either"}
"""Ids that PDDL reserves, and two that are equal where letters are."""
NASTY = (
    'the "good" one', "and", "not (InKit(x, y))", "a;b) (define (problem x", "ключ 漢字 🤖", "x\ny\tz", "$kit",
    '"} ; DROP ALL #', "> } INSERT DATA { sk:a sk:b sk:c } #", '"""', "\\", "a'b", "{0} %s ${x}", "<script>", "?x",
)  # fmt: skip
LABELS = st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=3, max_size=40)


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as served:
        yield served


@pytest.fixture(scope="module")
def api(served: Served) -> Iterator[httpx2.Client]:
    with api_of(served) as api:
        yield api


def called(api: httpx2.Client, label: str) -> None:
    """Calls a part so."""
    api.patch("/elements/relay_box_2", json={"label": label}, headers=ANYHOW).raise_for_status()


def in_kit(part: Any) -> dict[str, Any]:
    return {"condition": "ObjectAtLocation", "arguments": [part, "kit_1_d"]}


@settings(max_examples=25, deadline=None)
@given(LABELS)
@example("and")
@example("not (InKit(x, y))")
@example('"} ; DROP ALL #')
def test_a_goal_names_a_part_by_a_label_of_any_form(api: httpx2.Client, label: str) -> None:
    called(api, f"~{label}")  # which is no name of anything else
    answer = api.post("/goals/check", json={"goal": in_kit(f"~{label}")})

    assert answer.status_code in (200, 422), answer.text
    if answer.status_code == 200:
        assert answer.json()["text"] == "ObjectAtLocation(relay_box_2, kit_1_d)"
        again = api.post("/goals/check", json={"goal": answer.json()["text"]}).json()
        assert again["conditions"][0]["data"] == in_kit("relay_box_2")


@pytest.mark.parametrize("label", NASTY)
def test_a_label_with_special_characters_finds_its_element_in_goals_templates_and_queries(
    api: httpx2.Client, label: str
) -> None:
    called(api, label)

    by_goal = api.post("/goals/check", json={"goal": in_kit(label)}).json()
    template = {"parameters": [{"name": "part"}], "goal": [in_kit({"parameter": "part"})]}
    api.put("/documents/template/put away", json={"data": template}, headers=ANYHOW).raise_for_status()
    by_template = api.post("/goals/check", json={"work_master": "put away", "parameters": {"part": label}}).json()
    found = api.get("/elements", params={"label": label}).json()["items"]
    asked = {"query": "SELECT ?e { ?e rdfs:label $label }", "bindings": {"label": {"text": label}}}
    rows = api.post("/queries", json=asked).json()["rows"]

    assert by_goal["text"] == by_template["text"] == "ObjectAtLocation(relay_box_2, kit_1_d)"
    assert "relay_box_2" in [one["id"] for one in found]
    assert {"e": "relay_box_2"} in rows


def test_ids_that_are_reserved_or_equal_in_pddl_are_planned_with_correctly(
    api: httpx2.Client,
) -> None:
    begin_anew(api)
    text = api.get("/scene.ttl").text
    for old, new in ALIKE.items():
        text = text.replace(f"scene:{old} ", f"scene:{new} ")
    api.put("/scene", content=text.encode(), headers=TURTLE).raise_for_status()
    for id_, label in zip(ALIKE.values(), NASTY, strict=False):
        api.patch(f"/elements/{id_}", json={"label": label}, headers=ANYHOW).raise_for_status()
    places = [f"kit_1_{letter}" for letter in "abcd"]
    pairs = dict(zip(ALIKE.values(), places, strict=True))
    goal = [{"condition": "ObjectAtLocation", "arguments": [part, place]} for part, place in pairs.items()]

    api.put("/jobs/alike", json={"goal": goal}).raise_for_status()

    assert over(api, "alike")["outcome"] == "succeeded"
    there = {part: api.get(f"/elements/{part}").json()["placement"]["place"] for part in pairs}
    assert there == pairs


@pytest.mark.parametrize("id_", ["x;y", "a(b", "über", "x.y", "x\\;y", "x\\)", "1", "a-b", "_:x", "x> } #"])
def test_an_unusual_id_in_a_scene_is_either_an_ordinary_name_or_refused(api: httpx2.Client, id_: str) -> None:
    before = api.get("/scene.ttl").text
    spoilt = before + f'\nscene:{id_} a kitting:Starter ; rdfs:label "x" ; sk:in scene:pallet_a .\n'

    answer = api.put("/scene", content=spoilt.encode(), headers=TURTLE)

    if answer.status_code == 200:  # then it is a name like any other
        assert api.get(f"/elements/{id_}").json()["id"] == id_
        api.put("/scene", content=before.encode(), headers=TURTLE).raise_for_status()
    else:
        assert (answer.status_code, answer.json()["code"]) == (422, "SceneBroken")
    assert api.get("/scene.ttl").text == before


@settings(max_examples=15, deadline=None)
@given(st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=60))
@example('" . scene:floor sk:on scene:kit_1 . #')
@example('"""\n. \\" \r')
def test_a_label_is_unchanged_after_saving_and_loading_a_scene(api: httpx2.Client, label: str) -> None:
    api.patch("/elements/rack_1", json={"label": label or "x"}, headers=ANYHOW).raise_for_status()
    text = api.get("/scene.ttl").text

    api.put("/scene", content=text.encode(), headers=TURTLE).raise_for_status()

    assert api.get("/elements/rack_1").json()["label"] == (label or "x")
    assert api.get("/scene.ttl").text == text


def test_template_parameters_are_inserted_as_names_and_never_as_goal_text(api: httpx2.Client) -> None:
    template = {"parameters": [{"name": "part"}], "goal": [in_kit({"parameter": "part"})]}
    api.put("/documents/template/put away", json={"data": template}, headers=ANYHOW).raise_for_status()
    for injected in ("relay_box_1, kit_1_a) and InKit(Starter", "x) or (", json.dumps({"not": {}})):
        order = {"work_master": "put away", "parameters": {"part": injected}}
        refused = api.put("/jobs/injected", json=order)
        assert (refused.status_code, refused.json()["code"]) == (422, "UnknownName")
    assert api.get("/jobs/injected").status_code == 404
