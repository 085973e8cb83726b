"""Goals, templates and previews over the API of a real server."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import httpx2
import pytest
from support.serving import Served, serving

from skiros_py.api.goals import GoalOrder
from skiros_py.api.jobs import order_from
from skiros_py.client.client import Client
from skiros_py.client.topics import Goals, Previews

KIT = "InKit(Starter, kit_1)"
FILL = {
    "parameters": [{"name": "kit", "class": "Kit"}],
    "per_material": {"condition": "InKit", "arguments": [{"material": "class"}, {"parameter": "kit"}]},
}


@pytest.fixture(scope="module")
def served(tmp_path_factory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as server:
        yield server


@pytest.fixture(scope="module")
def api(served) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=f"{served.url}/api/v1", timeout=60.0) as client:
        yield client


def problem(response, status):
    assert response.status_code == status, response.text
    return response.json()


# ------------------------------------------------------------------ goals


def test_checking_a_goal_orders_no_job(api):
    checked = api.post("/goals/check", json={"goal": f"not {KIT} and EmptyHanded(gripper_1)"}).json()
    assert checked["text"] == "not InKit(kitting:Starter, kit_1) and EmptyHanded(gripper_1)"
    assert checked["holds"] is True
    wanted = api.post("/goals/check", json={"goal": [KIT]}).json()
    (condition,) = wanted["conditions"]
    assert (condition["holds"], wanted["holds"]) == (False, False)
    assert condition["data"] == {"condition": "InKit", "arguments": ["kitting:Starter", "kit_1"]}
    assert "no Starter" in condition["why"]
    assert len(condition["lines"]) > 1
    assert api.get("/jobs").json()["items"] == []


def test_a_checked_goal_is_accepted_again_as_data_and_as_text(api):
    goal = 'for all c: Compartment (HasPart(kit_1, c) implies not ObjectAtLocation("alternator_1", c))'
    first = api.post("/goals/check", json={"goal": goal}).json()
    for form in (first["text"], [one["data"] for one in first["conditions"]]):
        assert api.post("/goals/check", json={"goal": form}).json() == first


@pytest.mark.parametrize(
    ("goal", "code", "more"),
    [
        ("InKit(Starter kit_1)", "GoalSyntax", {"column": 15}),
        ("InKit(Startr, kit_1)", "UnknownName", {"nearest": "Starter"}),
        ({"condition": "InKt", "arguments": ["a", "b"]}, "UnknownName", {"nearest": "InKit"}),
        ({"not": {}}, "InvalidRequest", {}),
    ],
)
def test_an_invalid_goal_is_answered_with_what_would_be_valid(api, goal, code, more):
    refused = problem(api.post("/goals/check", json={"goal": goal}), 422)
    assert {"code": code, "return_status": 1 << 32, **more}.items() <= refused.items()


def test_a_condition_lists_the_narrower_class_that_robots_can_reach_for_a_role(
    api: httpx2.Client,
) -> None:
    words = {word["name"]: word for word in api.get("/goals/conditions").json()["items"]}
    _, location = words["ObjectAtLocation"]["roles"]
    assert location == {"name": "location", "class": "sk:Container", "reached": "kitting:Compartment"}
    assert all(role["reached"] == role["class"] for role in words["InKit"]["roles"])


def test_the_listed_conditions_are_those_that_the_robots_can_fulfil(api):
    words = {word["name"]: word for word in api.get("/goals/conditions").json()["items"]}
    assert words["InKit"]["skills"] == ["hand_over", "place", "search"]
    assert words["InKit"]["roles"][1] == {"name": "kit", "class": "kitting:Kit", "reached": "kitting:Kit"}
    assert (words["InKit"]["abstract"], words["EmptyHanded"]["abstract"]) == (True, False)
    assert words["RobotAtLocation"]["skills"] == ["drive"]
    assert "FitsIn" not in words
    every = {word["name"] for word in api.get("/goals/conditions?all=true").json()["items"]}
    assert every > set(words)


def test_goals_of_the_scene_are_replaced_only_with_their_latest_version(api):
    seen = api.get("/goals")
    assert problem(api.put("/goals", json={"goals": [KIT]}), 428)["code"] == "VersionMissing"
    head = {"If-Match": seen.headers["etag"]}
    problem(api.put("/goals", json={"goals": ["InKit(Startr, kit_1)"]}, headers=head), 422)
    structured = {"condition": "InKit", "arguments": ["Alternator", "kit_1"]}
    changed = api.put("/goals", json={"goals": [KIT, structured]}, headers=head)
    assert changed.json()["goals"] == ["InKit(Alternator, kit_1)", KIT]
    assert problem(api.put("/goals", json={"goals": []}, headers=head), 412)["code"] == "StaleVersion"
    assert api.get("/goals").headers["etag"] == changed.headers["etag"]


# ------------------------------------------------------------------ templates


def test_a_template_is_overwritten_only_with_its_latest_version(api):
    first = api.put("/documents/template/fill a kit", json={"data": FILL})
    assert first.status_code == 201
    problem(api.put("/documents/template/fill a kit", json={"data": FILL}), 428)
    head = {"If-Match": first.headers["etag"]}
    second = api.put(
        "/documents/template/fill a kit", json={"data": {**FILL, "description": "for all kits"}}, headers=head
    )
    assert second.status_code == 200
    problem(api.put("/documents/template/fill a kit", json={"data": FILL}, headers=head), 412)
    problem(api.delete("/documents/template/fill a kit", headers=head), 412)
    assert api.get("/documents/template/fill a kit").json() == second.json()
    assert [one["id"] for one in api.get("/documents/template").json()["items"]] == ["fill a kit"]
    assert api.delete("/documents/template/fill a kit", headers={"If-Match": second.headers["etag"]}).status_code == 204
    problem(api.get("/documents/template/fill a kit"), 404)


def test_an_invalid_template_is_refused_with_the_path_of_the_fault(api):
    wrong = {"goal": [{"not": {"condition": "InKit", "arguments": [{"parameter": "kt"}, "kit_1"]}}]}
    assert (
        "goal[0].not.arguments[0]: unknown parameter 'kt'"
        in problem(api.put("/documents/template/x", json={"data": wrong}), 422)["detail"]
    )
    wrong["goal"][0]["not"]["condition"] = "InKt"
    wrong["parameters"] = [{"name": "kt"}]
    assert (
        "goal[0].not.condition: unknown condition 'InKt'"
        in problem(api.put("/documents/template/x", json={"data": wrong}), 422)["detail"]
    )
    problem(api.get("/documents/template/x"), 404)


def test_a_job_is_ordered_by_template_parameters_and_materials(api):
    api.put("/documents/template/fill", json={"data": FILL}).raise_for_status()
    order = {
        "work_master": "fill",
        "parameters": {"kit": "kit_1"},
        "materials": [{"class": "Starter", "use": "produced"}, {"class": "RelayBox"}],
    }
    job = api.put("/jobs/by-template", json=order, params={"start": "false"}).json()
    assert job["order"]["goal"] == ["InKit(Starter, kit_1)", "InKit(RelayBox, kit_1)"]
    assert job["order"]["work_master"] == "fill"
    assert [one["class"] for one in job["order"]["materials"]] == ["Starter", "RelayBox"]

    etag = api.get("/documents/template/fill").headers["etag"]
    api.delete("/documents/template/fill", headers={"If-Match": etag}).raise_for_status()
    again = api.put("/jobs/by-template", json=order, params={"start": "false"})
    assert (again.status_code, again.json()) == (200, job)
    problem(api.put("/jobs/by-template-2", json=order), 422)


@pytest.mark.parametrize(
    "name", ['kit_1") or EmptyHanded("gripper_1', "kit_1) and not InKit(Starter, kit_1", '"', "a\nb"]
)
def test_a_template_parameter_is_always_taken_as_a_name(api, name):
    api.put("/documents/template/inject", json={"data": FILL}, headers={"If-Match": "*"})
    order = {"work_master": "inject", "parameters": {"kit": name}, "materials": [{"class": "Starter"}]}
    refused = problem(api.post("/goals/check", json=order), 422)
    assert refused["code"] == "UnknownName"
    assert "unknown element" in refused["detail"]


# ------------------------------------------------------------------ previews


def planned(api, goal):
    asked = api.post("/previews", json={"goal": goal}).raise_for_status()
    return api.get(asked.headers["location"].removeprefix("/api/v1"), params={"wait": 30}).json()


def test_a_preview_shows_the_plan_without_executing_it(api, served):
    before = served.services.station.session.world.version
    asked = api.post("/previews", json={"goal": KIT})
    assert asked.status_code == 202
    preview = api.get(asked.headers["location"].removeprefix("/api/v1"), params={"wait": 30}).json()
    assert (preview["state"], preview["conditions"]) == ("planned", [KIT])
    assert [(step["skill"], step["after"]) for step in preview["steps"]] == [
        ("drive", []), ("pick", [0]), ("drive", [1]), ("place", [2])
    ]  # fmt: skip
    assert preview["wall"] > 0.0
    assert served.services.station.session.world.version == before == preview["world"]


def test_previewing_a_goal_that_already_holds_gives_a_plan_without_steps(api):
    preview = planned(api, "EmptyHanded(gripper_1)")
    assert (preview["state"], preview["steps"]) == ("planned", [])


def test_a_preview_without_a_plan_offers_repairs_that_make_a_plan_possible(api, served):
    world = served.services.station.session.world
    with world.transaction("ann", "somebody took it") as tx:
        tx.remove("starter_1")
    preview = planned(api, KIT)
    assert preview["state"] == "no plan"
    assert preview["reasons"] == [cause["text"] for cause in preview["causes"]]
    (repair, *_) = (one for one in preview["repairs"] if one["applicable"])
    before = world.version
    applied = api.post(f"/previews/{preview['id']}/repairs/{repair['id']}/apply").json()
    assert (applied["text"], applied["world"]) == (repair["text"], before + 1)
    assert applied["texts"][applied["text"]] == preview["texts"][repair["text"]]
    assert (world.changes[-1].author, world.version) == ("local", before + 1)
    assert planned(api, KIT)["state"] == "planned"


def test_a_repair_that_only_changes_the_goal_cannot_be_applied(api, served):
    before = served.services.station.session.world.version
    preview = planned(api, f"{KIT} and not {KIT}")
    assert preview["state"] == "no plan"
    (repair, *_) = (one for one in preview["repairs"] if one["without"])
    refused = problem(api.post(f"/previews/{preview['id']}/repairs/{repair['id']}/apply"), 409)
    assert refused["code"] == "RepairNotApplicable"
    assert served.services.station.session.world.version == before


def test_applying_a_repair_of_world_and_goal_reports_only_the_world_change_as_done(api, served):
    with served.services.station.session.world.transaction("ann", "it is taken") as tx:
        tx.place("alternator_1", "sk:in", "kit_1_a")
    boxes = " and ".join(f"ObjectAtLocation({box}, kit_1_a)" for box in ("relay_box_1", "relay_box_2"))
    preview = planned(api, f"{boxes} and " + " and ".join(f"LocationEmpty(kit_1_{place})" for place in "bcd"))
    (repair, *_) = (one for one in preview["repairs"] if one["edits"] and one["without"])

    applied = api.post(f"/previews/{preview['id']}/repairs/{repair['id']}/apply").json()

    assert "give up" in repair["text"]
    assert applied["text"] == " and ".join(repair["edits"])


def test_an_unknown_repair_is_refused(api):
    preview = planned(api, "EmptyHanded(gripper_1)")
    problem(api.post(f"/previews/{preview['id']}/repairs/0/apply"), 404)
    problem(api.post("/previews/99/repairs/0/apply"), 404)


def test_at_most_two_previews_are_planned_at_once_and_others_get_a_retry_time(api, served):
    def ask(_):
        return api.post("/previews", json={"goal": KIT})

    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(ask, range(8)))
    taken = [answer for answer in answers if answer.status_code == 202]
    busy = [answer for answer in answers if answer.status_code == 503]
    assert len(taken) >= 2
    assert len(taken) + len(busy) == 8
    assert busy
    assert all(int(answer.headers["retry-after"]) >= 1 for answer in busy)
    for answer in taken:
        path = answer.headers["location"].removeprefix("/api/v1")
        assert api.get(path, params={"wait": 30}).json()["state"] == "planned"


def test_an_unknown_preview_is_refused(api):
    problem(api.get("/previews/4711"), 404)


def test_listeners_receive_written_and_removed_templates(api):
    place = {"after": api.get("/events/recent", params={"limit": 1000}).json()["next"]}
    tag = api.put("/documents/template/told", json={"data": FILL}).headers["etag"]
    api.delete("/documents/template/told", headers={"If-Match": tag})

    heard = api.get("/events/recent", params={"kind": "document", **place}).json()["items"]

    assert [(one["type"], one["subject"], one["data"]["kind"]) for one in heard] == [
        ("written", "told", "template"),
        ("removed", "told", "template"),
    ]


# ------------------------------------------------------------------ the client


def test_the_client_reads_and_writes_goals_templates_and_previews(served):
    with Client(served.url) as client:
        written = client.documents.put("template", "by client", FILL)
        assert client.documents.get("template", "by client") == written
        order = order_from(template="by client", parameters={"kit": "kit_1"}, materials=("RelayBox",))
        assert client.send(Goals.check(order)).text == "InKit(kitting:RelayBox, kit_1)"
        client.documents.remove("template", "by client", seen=written.revision)
        assert "by client" not in {one.id for one in client.documents.list("template").items}
        goals, seen = client.send(Goals.get())
        assert client.send(Goals.put(goals.goals, seen=seen)).goals == goals.goals
        assert client.send(Goals.conditions(every=True)).items
        asked = client.send(Previews.ask(GoalOrder(goal="EmptyHanded(gripper_1)")))
        assert client.send(Previews.get(asked.id, wait=30)).state == "planned"
        assert asked.id in {preview.id for preview in client.send(Previews.list()).items}


def test_a_server_shuts_down_without_waiting_for_plans(tmp_path):
    with serving("kitting", tmp_path) as served:
        httpx2.post(f"{served.url}/api/v1/previews", json={"goal": KIT}).raise_for_status()
        (preview,) = served.services.station.previews._previews.values()
    assert preview.ended.is_set()
