"""SPARQL over REST: answers in three forms, and whatever is asked, the server goes on."""

from __future__ import annotations

import csv
import io
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from typing import Any

import httpx2
import pytest
from support.serving import Served, serving

PARTS = "SELECT ?part { ?part sk:in $place }"


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as served:
        yield served


@pytest.fixture(scope="module")
def api(served: Served) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=f"{served.url}/api/v1", timeout=30.0) as client:
        yield client


def ask(api: httpx2.Client, query: str, accept: str = "application/json", **more: Any) -> httpx2.Response:
    return api.post("/queries", json={"query": query, **more}, headers={"Accept": accept})


def refused(response: httpx2.Response, status: int = 422) -> str:
    assert response.status_code == status, response.text
    detail: str = response.json()["detail"]
    return detail


def goes_on(api: httpx2.Client) -> None:
    assert ask(api, "ASK { scene:kit_1 a kitting:Kit }").json() == {"form": "ASK", "answer": True}


# ------------------------------------------------------------------ answers


def test_a_select_returns_rows_of_names_and_values(api: httpx2.Client) -> None:
    told = ask(api, PARTS, bindings={"place": "pallet_a"}).json()
    poses = ask(api, "SELECT ?pose ?nothing { scene:pallet_a sk:pose ?pose }").json()

    assert (told["form"], told["variables"]) == ("SELECT", ["part"])
    assert {"part": "starter_1"} in told["rows"]
    assert poses["rows"] == [
        {"pose": {"position": [5.0, 1.6, 0.0], "orientation": [0.0, 0.0, 0.0, 1.0]}, "nothing": None}
    ]


def test_rows_are_available_as_csv_and_triples_as_turtle(api: httpx2.Client) -> None:
    rows = ask(api, PARTS, "text/csv", bindings={"place": "pallet_a"})
    triples = ask(api, "CONSTRUCT WHERE { ?part sk:in scene:pallet_a }", "text/turtle")
    plain = ask(api, "CONSTRUCT WHERE { ?part sk:in scene:pallet_a }").json()

    assert rows.headers["content-type"].startswith("text/csv")
    assert ["starter_1"] in list(csv.reader(io.StringIO(rows.text)))
    assert "scene:starter_1" in triples.text
    assert ["starter_1", "sk:in", "pallet_a"] in plain["statements"]
    assert refused(ask(api, "ASK { ?a ?b ?c }", "text/csv"), 406)
    assert refused(ask(api, PARTS, "text/turtle", bindings={"place": "pallet_a"}), 406)


def test_queries_include_computed_and_entailed_relations(api: httpx2.Client) -> None:
    graspable = ask(api, "SELECT ?part { ?part sk:graspableBy scene:gripper_1 }").json()["rows"]
    placed = "ASK { scene:starter_1 sk:placement ?where }"

    assert {"part": "starter_1"} in graspable
    assert ask(api, placed).json()["answer"] is False
    assert ask(api, placed, entailed=True).json()["answer"] is True


def test_a_query_sees_changes_written_just_before(api: httpx2.Client) -> None:
    for number in range(3):
        api.patch("/elements/kit_1", json={"label": f"kit {number}"}, headers={"If-Match": "*"})
        rows = ask(api, "SELECT ?label { scene:kit_1 rdfs:label ?label }").json()["rows"]
        assert rows == [{"label": f"kit {number}"}]


def test_a_query_parameter_may_have_any_name(api: httpx2.Client) -> None:
    for name in ("sparql", "entailed", "time_limit", "self", "form"):
        told = ask(api, f"SELECT ?part {{ ?part sk:in ${name} }}", bindings={name: "pallet_a"}).json()
        assert {"part": "starter_1"} in told["rows"]


@pytest.mark.parametrize(
    ("value", "other"),
    [({"text": "pallet A"}, "pallet_a"), ({"decimal": "0.8"}, 0.8), (True, "true"), (8, "8"), ([1.0, 2.0], [1.0])],
)
def test_each_kind_of_value_can_be_bound(api: httpx2.Client, value: Any, other: Any) -> None:
    same = "ASK { FILTER(sameTerm($value, $other)) }"

    assert ask(api, same, bindings={"value": value, "other": value}).json()["answer"] is True
    assert ask(api, same, bindings={"value": value, "other": other}).json()["answer"] is False


# ------------------------------------------------------------------ case 8: what must not hurt


@pytest.mark.parametrize(
    "update", ["INSERT DATA { sk:a sk:b sk:c }", "DELETE WHERE { ?a ?b ?c }", "DROP ALL", "CLEAR ALL"]
)
def test_a_query_changes_nothing(api: httpx2.Client, update: str) -> None:
    before = api.get("/world").json()["version"]

    assert "changes" in refused(ask(api, update))
    assert "changes" in refused(ask(api, f"PREFIX x: <urn:x> {update}"))
    assert api.get("/world").json()["version"] == before


@pytest.mark.parametrize(
    "deep", ["{" * 5000, "ASK " + "{" * 5000 + "}" * 5000, "ASK { FILTER(" + "!" * 10000 + "true) }"]
)
def test_a_query_nested_thousands_deep_is_refused(api: httpx2.Client, deep: str) -> None:
    assert refused(ask(api, deep))
    goes_on(api)


def test_a_query_cannot_reach_another_endpoint(api: httpx2.Client) -> None:
    asked: list[str] = []

    class Listener(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked.append(self.path)
            self.send_error(404)

        do_POST = do_GET  # noqa: N815

    with HTTPServer(("127.0.0.1", 0), Listener) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        url = f"http://127.0.0.1:{server.server_port}/secret"
        for question in (
            f"SELECT * {{ SERVICE <{url}> {{ ?a ?b ?c }} }}",
            f"SELECT * {{ SERVICE SILENT <{url}> {{ ?a ?b ?c }} }}",
            f"SELECT * FROM <{url}> {{ ?a ?b ?c }}",
            f"LOAD <{url}>",
            "LOAD <file:///etc/passwd>",
            "SELECT * { SERVICE <http://169.254.169.254/latest> { ?a ?b ?c } }",
        ):
            assert refused(ask(api, question))
        server.shutdown()

    assert asked == []


def test_a_query_that_takes_too_long_is_cancelled(api: httpx2.Client) -> None:
    product = "SELECT (COUNT(*) AS ?n) { ?a ?b ?c . ?d ?e ?f . ?g ?h ?i . ?j ?k ?l }"

    assert "took longer than 0.5 s" in refused(ask(api, product, time_limit=0.5))
    goes_on(api)


def test_an_answer_that_is_too_large_is_refused(api: httpx2.Client) -> None:
    assert "10000" in refused(ask(api, "SELECT * { ?a ?b ?c . ?d ?e ?f }")).replace(",", "")
    goes_on(api)


def test_too_many_queries_at_once_are_refused_with_a_retry_time(api: httpx2.Client) -> None:
    product = "SELECT (COUNT(*) AS ?n) { ?a ?b ?c . ?d ?e ?f . ?g ?h ?i . ?j ?k ?l }"
    statuses: list[tuple[int, str | None]] = []

    def one() -> None:
        response = ask(api, product, time_limit=2.0)
        statuses.append((response.status_code, response.headers.get("retry-after")))

    threads = [threading.Thread(target=one) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()

    assert {status for status, _ in statuses} == {422, 503}
    assert {after for status, after in statuses if status == 503} == {"1"}
    goes_on(api)


# ------------------------------------------------------------------ case 9: names and texts are never query text


@pytest.mark.parametrize(
    "text",
    ['"} ; DROP ALL #', "x\n} INSERT DATA { sk:a sk:b sk:c", "> } #", "\\", '"""', "a'b", "\u2028", "$other ?x"],
)
def test_a_bound_text_is_never_parsed_as_sparql(api: httpx2.Client, text: str) -> None:
    told = ask(api, "SELECT ?same { BIND($text AS ?same) }", bindings={"text": {"text": text}}).json()

    assert told["rows"] == [{"same": text}]


@pytest.mark.parametrize("name", ["x> } ; DROP ALL #", "a b", "scene:x}", "x\n", "nowhere:x", "<http://x>", "\u0000"])
def test_a_bound_name_is_never_parsed_as_sparql(api: httpx2.Client, name: str) -> None:
    response = ask(api, "SELECT ?x { ?x sk:in $place }", bindings={"place": name})

    assert response.status_code in (200, 400, 422)
    assert response.status_code != 200 or response.json()["rows"] == []
    goes_on(api)


@pytest.mark.parametrize(
    "body", [{"query": ""}, {"query": "ASK {}", "time_limit": 0}, {"query": "ASK {}", "time_limit": 1e9}]
)
def test_an_invalid_query_request_is_refused(api: httpx2.Client, body: dict[str, Any]) -> None:
    assert refused(api.post("/queries", json=body))
