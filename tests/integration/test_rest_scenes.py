"""Scenes over REST: looked at, loaded, uploaded, saved; what is broken changes nothing."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import httpx2
import pytest
import rdflib
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.serving import Served, serving

from skiros_py.client.client import Client
from skiros_py.client.topics import Scenes
from skiros_py.errors import DeviceError
from skiros_py.station.session import Session
from skiros_py.tasks.handle import TaskHandle
from skiros_py.world.change import Writer
from skiros_py.world.names import SCENE
from skiros_py.world.undo import undo

ANY = {"If-Match": "*"}
TURTLE = {**ANY, "Content-Type": "text/turtle"}
_LAUGHS = "".join(f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 10))
BOMB = f'<?xml version="1.0"?><!DOCTYPE r [<!ENTITY l0 "lol">{_LAUGHS}]><r>&l9;</r>'
EXTERNAL = '<?xml version="1.0"?><!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><r>&x;</r>'


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as server:
        yield server


@pytest.fixture
def http(served: Served) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=f"{served.url}/api/v1", timeout=60.0) as client:
        client.put("/scene", json={"name": "kitting"}, headers=ANY).raise_for_status()
        yield client


def now(served: Served) -> str:
    with Client(served.url) as client:
        return client.send(Scenes.turtle())


def test_installed_scenes_are_listed_page_by_page(served: Served, http: httpx2.Client) -> None:
    first = http.get("/scenes", params={"limit": 1}).json()
    second = http.get("/scenes", params={"cursor": first["next"]}).json()

    names = [one["name"] for page in (first, second) for one in page["items"]]
    assert len(first["items"]) == 1
    assert {"kitting", "kitting_carried", "kitting_two"} <= set(names)
    assert names == sorted(names)
    assert second["next"] is None


def test_a_scene_can_be_described_without_loading_it(served: Served, http: httpx2.Client) -> None:
    with Client(served.url) as client:
        other, present = client.send(Scenes.file("kitting_two")), client.send(Scenes.get())

    assert [robot.id for robot in other.robots] == ["robot_1", "robot_2"]
    assert len(other.goals) == 4
    assert (present.name, [robot.id for robot in present.robots]) == ("kitting", ["robot_1"])
    assert http.get("/scenes/nowhere").json()["code"] == "UnknownScene"


def test_a_scene_just_loaded_is_unchanged_and_an_edit_changes_it(served: Served, http: httpx2.Client) -> None:
    assert http.get("/scene").json()["changed"] is False

    with served.services.station.session.world.transaction("ann", "paints it", writer=Writer.PERSON) as tx:
        tx.set("starter_1", "rdfs:label", "red starter")

    assert http.get("/scene").json()["changed"] is True
    difference = http.get("/scene/diff", params={"with": "kitting"}).json()
    assert difference["lines"] == ["~ starter_1 rdfs:label 'starter' -> 'red starter'"]
    assert (difference["total"], difference["next"]) == (1, None)


def test_loading_a_scene_starts_its_robots_and_keeps_learned_concepts(served: Served, http: httpx2.Client) -> None:
    with served.services.station.session.world.transaction("ann", "taught", writer=Writer.PERSON) as tx:
        mug = tx.add("kitting:Starter", label="mug", learned=True)

    loaded = http.put("/scene", json={"name": "kitting_two"}, headers={"If-Match": http.get("/scene").headers["ETag"]})

    assert loaded.status_code == 200
    assert loaded.headers["ETag"] == f'"{loaded.json()["version"]}"'
    assert {"base_1", "base_2"} <= served.services.station.session.managers.keys()
    assert served.services.station.session.world.has(mug)


def test_loading_is_one_change_that_can_be_undone(served: Served, http: httpx2.Client) -> None:
    before = now(served)
    http.put("/scene", json={"name": "kitting_carried"}, headers=ANY)
    assert http.get("/scene").json()["name"] == "kitting_carried"

    undo(served.services.station.session.world, "ann")

    assert now(served) == before
    assert http.get("/scene").json()["name"] == "kitting"


def test_reopening_a_session_writes_nothing_into_the_world(served: Served, http: httpx2.Client) -> None:
    before = http.get("/scene").headers["ETag"]
    http.post("/simulation/reset").raise_for_status()

    assert http.get("/scene").headers["ETag"] == before


def test_a_scene_that_changed_since_it_was_read_is_not_replaced(served: Served, http: httpx2.Client) -> None:
    seen = http.get("/scene").headers["ETag"]
    with served.services.station.session.world.transaction("ben", "meanwhile", writer=Writer.PERSON) as tx:
        tx.set("starter_1", "rdfs:label", "mine")
    before = now(served)

    assert http.put("/scene", json={"name": "kitting"}, headers={"If-Match": seen}).status_code == 412
    assert http.put("/scene", json={"name": "kitting"}).status_code == 428
    assert now(served) == before


def test_a_locked_element_prevents_others_from_loading_another_scene(served: Served, http: httpx2.Client) -> None:
    locks = served.services.station.session.world.locks
    locks.acquire(["starter_1"], "ben", 60.0)
    try:
        with served.services.station.session.world.transaction("ben", "mine", writer=Writer.PERSON) as tx:
            tx.set("starter_1", "rdfs:label", "ben's")
        refused = http.put("/scene", json={"name": "kitting"}, headers=ANY)
    finally:
        locks.release("ben")

    assert (refused.status_code, refused.json()["code"]) == (423, "Locked")
    assert http.get("/scene").status_code == 200


def test_while_a_job_runs_neither_a_scene_load_nor_a_reset_is_allowed(served: Served, http: httpx2.Client) -> None:
    def begin(session: Session) -> TaskHandle:
        task = session.tasks.begin(session.parse(["InKit(Starter, kit_1)"]), name="busy")
        task.pause()
        return task

    control = served.services.station.control
    busy = control.call(begin)
    before = http.get("/scene").headers["ETag"]
    answers = http.put("/scene", json={"name": "kitting_two"}, headers=ANY), http.post("/simulation/reset")
    after = http.get("/scene").headers["ETag"]
    control.call(lambda _: busy.stop("the test is over"))
    while not control.call(lambda session: session.resting):
        pass

    assert [(answer.status_code, answer.json()["code"]) for answer in answers] == [(409, "WrongState")] * 2
    assert before == after


def test_while_a_job_is_held_no_scene_is_loaded_and_a_forced_reset_keeps_the_job(
    served: Served, http: httpx2.Client
) -> None:
    http.put("/jobs/held", json={"goal": "InKit(Starter, kit_1)"}).raise_for_status()
    while http.get("/jobs/held").json()["state"]["text"] != "Running":
        pass
    http.post("/simulation/reset", params={"force": True}).raise_for_status()
    before = http.get("/jobs/held").json()
    answers = http.put("/scene", json={"name": "kitting_two"}, headers=ANY), http.post("/simulation/reset")
    http.post("/simulation/reset", params={"force": True}).raise_for_status()
    after = http.get("/jobs/held").json()
    http.post("/jobs/held/abort").raise_for_status()
    while http.get("/jobs/held").json()["state"]["text"] != "Aborted":
        pass

    assert before["state"]["text"] == "Interrupted"
    assert [(answer.status_code, answer.json()["code"]) for answer in answers] == [(409, "WrongState")] * 2
    assert all("job 'held' waits in the middle of its work" in answer.json()["detail"] for answer in answers)
    assert after["version"] == before["version"]
    assert http.put("/scene", json={"name": "kitting"}, headers=ANY).status_code == 200


def test_loading_a_scene_with_another_robot_cannot_be_undone_and_the_answer_says_what_to_do(
    http: httpx2.Client,
) -> None:
    http.put("/scene", json={"name": "kitting_two"}, headers=ANY).raise_for_status()

    refused = http.post("/world/undo")

    assert (refused.status_code, refused.json()["code"]) == (409, "CannotUndo")
    assert refused.json()["detail"].endswith("load the former scene instead: PUT /scene")
    assert http.put("/scene", json={"name": "kitting"}, headers=ANY).json()["changed"] is False


def test_a_scene_exported_as_turtle_can_be_uploaded_again(served: Served, http: httpx2.Client) -> None:
    text = now(served).replace('"starter"', '"painted"')

    sent = http.put("/scene", content=text.encode(), headers=TURTLE)

    assert (sent.status_code, sent.json()["name"], sent.json()["changed"]) == (200, "", None)
    assert served.services.station.session.world.element("starter_1").label == "painted"
    assert now(served) == text


FORMATS = {
    "application/n-triples": "nt",
    "application/ld+json": "json-ld",
    "application/rdf+xml": "pretty-xml",
    "text/turtle; charset=utf-8": "turtle",
}


@pytest.mark.parametrize("media_type", FORMATS)
def test_a_scene_can_be_uploaded_in_each_format(served: Served, http: httpx2.Client, media_type: str) -> None:
    text = now(served)
    other = rdflib.Graph().parse(data=text, format="turtle").serialize(format=FORMATS[media_type])

    sent = http.put("/scene", content=other.encode(), headers={**ANY, "Content-Type": media_type})

    assert sent.status_code == 200, sent.text
    assert now(served) == text


def test_a_scene_in_owl_xml_can_be_uploaded_by_the_client(served: Served, http: httpx2.Client) -> None:
    individuals = re.findall(r"^scene:(\w+) a (\w+):(\w+) ;", now(served), re.MULTILINE)
    names = dict(re.findall(r"^@prefix (\w+): <(.*)> \.", now(served), re.MULTILINE))
    facts = "".join(
        f'<ClassAssertion><Class IRI="{names[prefix]}{class_}"/><NamedIndividual IRI="{SCENE}{name}"/></ClassAssertion>'
        for name, prefix, class_ in individuals
        if class_ in ("Root", "Floor", "UnknownLocation")
    )
    text = f'<Ontology xmlns="http://www.w3.org/2002/07/owl#" ontologyIRI="http://example.org/bare">{facts}</Ontology>'

    with Client(served.url) as client:
        loaded = client.scenes.upload(text, media_type="application/owl+xml")

    assert (loaded.elements, loaded.robots) == (len(re.findall("<Class ", text)), [])


@pytest.mark.parametrize("media_type", ["text/plain", "application/xml", ""])
def test_another_content_type_is_refused_with_the_list(http: httpx2.Client, media_type: str) -> None:
    refused = http.put("/scene", content=b"scene:this a sk:Scene .", headers={**ANY, "Content-Type": media_type})

    assert (refused.status_code, refused.json()["code"]) == (415, "UnsupportedMediaType")
    assert all(kind.partition(";")[0] in refused.json()["detail"] for kind in (*FORMATS, "application/owl+xml"))


HARMFUL = {
    "a bomb": ("application/rdf+xml", BOMB, "must stand for a plain text"),
    "an external entity": ("application/rdf+xml", EXTERNAL, "refers to another file"),
    "an external entity in OWL/XML": ("application/owl+xml", EXTERNAL, "refers to another file"),
    "a remote context": ("application/ld+json", '{"@context": "http://127.0.0.1:9/c"}', "nothing is fetched"),
}


@pytest.mark.parametrize("what", HARMFUL)
def test_an_upload_that_was_made_to_do_harm_is_refused(http: httpx2.Client, what: str) -> None:
    media_type, text, says = HARMFUL[what]

    refused = http.put("/scene", content=text.encode(), headers={**ANY, "Content-Type": media_type})

    assert (refused.status_code, refused.json()["code"]) == (422, "SceneBroken")
    assert says in refused.json()["detail"]
    assert "root:" not in refused.text


BROKEN = {
    "truncated": lambda text: text[: len(text) // 2],
    "utf-16": lambda text: text.encode("utf-16"),
    "zero byte": lambda text: text + "\0",
    "no text": lambda _: b"\xff\xff\xff",
    "nested": lambda text: text + "scene:x sk:on " + "[" * 10_000,
    "long literal": lambda text: text + f'scene:starter_1 rdfs:comment "{"x" * 900_000}" .',
    "import from the network": lambda text: (
        text + "<https://w3id.org/skiros-py/scene> owl:imports <http://127.0.0.1:9/x> ."
    ),
    "import of a file": lambda text: text + "<https://w3id.org/skiros-py/scene> owl:imports <file:///etc/passwd> .",
    "circle": lambda text: text.replace("sk:on scene:floor", "sk:on scene:kit_1", 1),
    "two places": lambda text: text + "scene:starter_1 sk:in scene:pallet_b .",
    "not a number": lambda text: text + 'scene:rack_1 sk:mass "NaN"^^xsd:double .',
    "too far": lambda text: text.replace("5 1.6 0 0 0 0", "1e308 0 0 0 0 0"),
    "unknown class": lambda text: text + "scene:x a kitting:Unicorn .",
    "no robot": lambda text: text.replace("a sk:Robot", "a kitting:Table"),
    "unknown goal": lambda text: text + 'scene:this sk:goal "Flies(robot_1)" .',
    "nothing": lambda _: "",
}


@pytest.mark.parametrize("how", BROKEN)
def test_a_broken_scene_is_refused_and_the_old_one_stays(served: Served, http: httpx2.Client, how: str) -> None:
    before = now(served)
    made = BROKEN[how](before)

    answer = http.put("/scene", content=made if isinstance(made, bytes) else made.encode(), headers=TURTLE)

    assert answer.status_code in (413, 422), answer.text
    assert "/tmp" not in answer.text
    assert now(served) == before
    assert http.get("/scene").json()["name"] == "kitting"


def test_a_faulty_scene_is_refused_with_the_line_of_the_fault(served: Served, http: httpx2.Client) -> None:
    lines = now(served).splitlines()
    lines.insert(10, "scene:starter_1 sk:in in in .")

    problem = http.put("/scene", content="\n".join(lines).encode(), headers=TURTLE).json()

    assert (problem["code"], problem["line"]) == ("SceneBroken", 11)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.binary(max_size=300))
def test_no_uploaded_scene_breaks_the_server(served: Served, http: httpx2.Client, text: bytes) -> None:
    assert http.put("/scene", content=text, headers=TURTLE).status_code == 422
    assert http.put("/scene", content=text, headers={**ANY, "Content-Type": "application/json"}).status_code in (
        400,
        404,
        422,
    )


def test_the_old_scene_is_restored_if_the_station_cannot_start_with_the_new_one(
    served: Served, http: httpx2.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, control = now(served), served.services.station.control

    def refuse_two_robots(session: object) -> None:
        if len(session.managers) > 2:  # type: ignore[attr-defined]
            raise ValueError("the second robot does not answer")

    monkeypatch.setattr(control, "_on_open", [*control._on_open, refuse_two_robots])
    answer = http.put("/scene", json={"name": "kitting_two"}, headers=ANY)

    assert answer.status_code == 500
    assert now(served) == before
    assert http.get("/scene").json()["name"] == "kitting"


def test_a_scene_whose_driver_raises_is_refused_with_the_name_of_the_driver(
    served: Served, http: httpx2.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    control = served.services.station.control

    def refuse_two_robots(session: object) -> None:
        if len(session.managers) > 2:  # type: ignore[attr-defined]
            raise DeviceError("driver 'toy' of toy-robots 1.0 breaks: OSError: no route to host")

    monkeypatch.setattr(control, "_on_open", [*control._on_open, refuse_two_robots])
    answer = http.put("/scene", json={"name": "kitting_two"}, headers=ANY)

    assert answer.status_code == 422
    assert "driver 'toy' of toy-robots 1.0 breaks" in answer.json()["detail"]
    assert http.get("/scene").json()["name"] == "kitting"


def test_the_current_scene_can_be_saved_read_loaded_and_removed(served: Served, http: httpx2.Client) -> None:
    with Client(served.url) as client:
        entry = client.send(Scenes.save("my-cell"))
        file = client.send(Scenes.file("my-cell"))
        loaded = client.send(Scenes.load("my-cell"))
        client.send(Scenes.delete("my-cell", seen=file.version))

    assert (entry.source, file.elements, loaded.changed) == ("saved", loaded.elements, False)
    assert http.get("/scenes/my-cell").status_code == 404


def test_saving_a_scene_publishes_no_document_event(http: httpx2.Client) -> None:
    place = {"after": http.get("/events/recent", params={"limit": 1000}).json()["next"]}

    assert http.post("/scenes", json={"name": "quiet"}).status_code == 201

    assert http.get("/events/recent", params={"kind": "document", **place}).json()["items"] == []


def test_two_engineers_do_not_overwrite_each_others_scene(served: Served, http: httpx2.Client) -> None:
    first = http.post("/scenes", json={"name": "shared"})
    blind = http.post("/scenes", json={"name": "shared"})
    with served.services.station.session.world.transaction("ann", "paints it", writer=Writer.PERSON) as tx:
        tx.set("starter_1", "rdfs:label", "green")
    second = http.post("/scenes", json={"name": "shared"}, headers={"If-Match": first.headers["ETag"]})
    stale = http.post("/scenes", json={"name": "shared"}, headers={"If-Match": first.headers["ETag"]})

    assert [first.status_code, blind.status_code, second.status_code, stale.status_code] == [201, 428, 201, 412]
    assert http.delete("/scenes/shared", headers={"If-Match": first.headers["ETag"]}).status_code == 412
    assert http.delete("/scenes/shared", headers={"If-Match": second.headers["ETag"]}).status_code == 204


@pytest.mark.parametrize("name", ["../x", "/etc/passwd", "a\0b", "x" * 65, "A", "-x", "x.ttl", "", "ä", "a/b", "\n"])
def test_invalid_scene_names_are_refused(served: Served, http: httpx2.Client, name: str) -> None:
    assert http.post("/scenes", json={"name": name}).status_code in (400, 422)
    assert not (served.services.station.data.parent / "x.ttl").exists()


def test_symbolic_links_out_of_the_scene_folder_are_not_followed(
    served: Served, http: httpx2.Client, tmp_path: Path
) -> None:
    folder = served.services.station.data / "scenes"
    folder.mkdir(exist_ok=True)
    target = tmp_path / "secret.ttl"
    target.write_text("secret")
    (folder / "link.ttl").symlink_to(target)

    answers = (
        http.get("/scenes/link"),
        http.put("/scene", json={"name": "link"}, headers=ANY),
        http.post("/scenes", json={"name": "link"}),
    )

    assert {answer.status_code for answer in answers} == {409}
    assert target.read_text() == "secret"
    assert "link" not in [one["name"] for one in http.get("/scenes").json()["items"]]


def test_installed_scenes_are_neither_replaced_nor_removed(served: Served, http: httpx2.Client) -> None:
    answers = http.post("/scenes", json={"name": "kitting"}), http.delete("/scenes/kitting")

    assert [(answer.status_code, answer.json()["code"]) for answer in answers] == [(409, "SceneInstalled")] * 2


def test_an_unwritable_folder_is_reported_and_nothing_is_partly_written(
    served: Served, http: httpx2.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    blocked = served.services.station.data / "blocked"
    blocked.write_text("")
    monkeypatch.setattr(served.services.station.scene_store, "_folder", blocked)

    answer = http.post("/scenes", json={"name": "full"})

    assert (answer.status_code, answer.json()["code"]) == (507, "NotSaved")
