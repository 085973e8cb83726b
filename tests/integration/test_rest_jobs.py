"""What a factory system orders, commands and reads: jobs over the API of a real server."""

import json
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from http.client import HTTPResponse
from urllib.parse import quote

import httpx2
import pytest
from support.crowd import connect, crowd
from support.serving import Served, serving

from skiros_py.api.jobs import JobOrder, JobResponse
from skiros_py.client.client import Client
from skiros_py.client.topics import Jobs
from skiros_py.errors import UsageError
from skiros_py.station.jobs.intake import MOST_WAITING
from skiros_py.tasks.jobs.job import JobOrder as Order
from skiros_py.tasks.jobs.job import Outcome
from skiros_py.world.element import Placement

from .hard import until

HOLDS = {"goal": "EmptyHanded(gripper_1)"}
"""Nothing has to be done for it."""
OTHER = {"goal": "LocationEmpty(kit_1_b)"}
HOPELESS = {"goal": " and ".join(["InKit(Starter, kit_1)", *(f"LocationEmpty(kit_1_{one})" for one in "abcd")])}
"""The kit has no other compartments."""
LATER = {"not_before": "2100-01-01T00:00:00Z"}
STORE = {"start": "false"}
TAKEN = {"return_status": 1}
DONE = {"Prefer": "wait=30"}


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
    assert response.headers["content-type"] == "application/problem+json"
    return response.json()


def over(served, id_):
    """Waits until a job is over, and returns it."""
    jobs, changed = served.services.station.session.jobs, threading.Event()
    end = jobs.subscribe(lambda _job: changed.set())
    try:
        while jobs.job(id_).outcome is None:
            assert changed.wait(30.0)
            changed.clear()
        return jobs.job(id_)
    finally:
        end()


def state(job):
    return job["state"]["text"], tuple(job["state"]["substates"])


# ------------------------------------------------------------------ ordering


def test_an_order_is_accepted_at_once_executed_and_reported(api):
    taken = api.put("/jobs/kit-1", json={"goal": "InKit(Starter, kit_1)", "description": "the first"})
    assert taken.status_code == 202
    assert taken.headers["location"] == "/api/v1/jobs/kit-1"
    assert taken.headers["etag"] == f'"{taken.json()["version"]}"'
    assert taken.headers["retry-after"] == "1"

    done = api.put("/jobs/kit-1-again", json={"goal": "InKit(Starter, kit_1)"}, headers=DONE)
    assert done.status_code == 200
    assert done.json()["outcome"] == "goal already satisfied"

    job = api.get("/jobs/kit-1").json()
    assert (state(job), job["outcome"]) == (("Ended", ("Completed", "Closed")), "succeeded")
    assert job["commands"] == ["clear"]
    response = JobResponse.model_validate(api.get("/jobs/kit-1/response").json())
    assert [one.text for one in response.job_state] == ["Ended", "Completed", "Closed"]
    (moved,) = response.material_actuals
    assert (moved.class_, moved.origin, moved.place) == ("kitting:Starter", "pallet_a", "kit_1_a")
    assert [step.skill for step in response.job_response_data] == ["drive", "pick", "drive", "place"]
    assert {step.ended for step in response.job_response_data} == {"done"}
    assert [one.state.number for one in response.transitions] == [2, 3, 5]

    plan = api.get("/jobs/kit-1/plan").json()["items"]
    assert [(step["skill"], step["after"]) for step in plan] == [
        ("drive", []), ("pick", [0]), ("drive", [1]), ("place", [2])
    ]  # fmt: skip
    assert plan[3]["arguments"]["Compartment"] == "kit_1_a"
    report = api.get("/jobs/kit-1/report").json()
    assert (report["reached"], len(report["steps"])) == (True, 4)
    assert all(step["end"] > step["start"] for step in report["steps"])
    trace = api.get("/jobs/kit-1/trace", params={"limit": 3}).json()
    assert [entry["what"] for entry in trace["items"]] == ["begun", "planned", "started"]
    rest = api.get("/jobs/kit-1/trace", params={"limit": 1000, "cursor": trace["next"]}).json()
    assert (rest["items"][-1]["what"], rest["next"]) == ("finished", None)


def test_sending_the_same_order_fifty_times_at_once_creates_one_job(api):
    def put(_):
        return api.put("/jobs/once", json={**HOLDS, **LATER})

    with ThreadPoolExecutor(16) as pool:
        answers = list(pool.map(put, range(50)))
    assert {answer.status_code for answer in answers} <= {200, 202}
    assert len({answer.text for answer in answers}) == 1
    assert answers[0].json()["attempts"] == 0


def test_sending_one_idempotency_key_fifty_times_at_once_creates_one_job(api):
    def post(_):
        return api.post("/jobs", json={**HOLDS, **LATER}, headers={"Idempotency-Key": '"fifty"'})

    with ThreadPoolExecutor(16) as pool:
        answers = list(pool.map(post, range(50)))
    assert {answer.status_code for answer in answers} <= {200, 202}
    assert len({answer.json()["id"] for answer in answers}) == 1
    assert post(51).status_code == 200


def test_an_idempotency_key_belongs_to_one_order_even_after_its_job_is_removed(api):
    head = {"Idempotency-Key": "key-1"}
    first = api.post("/jobs", json=HOLDS, params=STORE, headers=head)
    again = api.post("/jobs", json=HOLDS, params=STORE, headers={"Idempotency-Key": '"key-1"'})
    assert again.json() == first.json()
    assert again.headers["idempotency-replayed"] == "true"
    reused = problem(api.post("/jobs", json=OTHER, params=STORE, headers=head), 422)
    assert (reused["code"], reused["return_status"]) == ("IdempotencyKeyReused", 1 << 32)

    api.post(f"/jobs/{first.json()['id']}/cancel").raise_for_status()
    replayed = api.post("/jobs", json=HOLDS, params=STORE, headers=head)
    assert replayed.json()["id"] == first.json()["id"]
    problem(api.get(f"/jobs/{first.json()['id']}"), 404)


@pytest.mark.parametrize("key", ["", '""', "a" * 201, "a b", 'a"b'])
def test_an_invalid_idempotency_key_is_refused(api, key):
    problem(api.post("/jobs", json=HOLDS, headers={"Idempotency-Key": key}), 422)


def test_another_order_under_the_same_id_needs_the_latest_version_of_the_job(api):
    first = api.put("/jobs/change", json={**HOLDS, **LATER})
    refused = problem(api.put("/jobs/change", json={**OTHER, **LATER}), 409)
    assert (refused["code"], refused["return_status"]) == ("UnableToAcceptJobOrder", 1 << 4)
    assert first.headers["etag"] in refused["detail"]

    changed = api.put("/jobs/change", json={**OTHER, **LATER}, headers={"If-Match": first.headers["etag"]})
    assert (changed.status_code, changed.json()["order"]["goal"]) == (200, ["LocationEmpty(kit_1_b)"])
    stale = api.put("/jobs/change", json={**HOLDS, **LATER}, headers={"If-Match": first.headers["etag"]})
    assert problem(stale, 412)["code"] == "StaleVersion"
    assert api.put("/jobs/change", json={**OTHER, **LATER}).json() == changed.json()


def test_a_started_job_refuses_another_order(api):
    done = api.put("/jobs/over", json=HOLDS, headers=DONE)
    refused = problem(api.put("/jobs/over", json=OTHER, headers={"If-Match": done.headers["etag"]}), 409)
    assert (refused["code"], refused["return_status"]) == ("InvalidJobOrderStatus", 1 << 3)
    assert api.get("/jobs/over").json() | TAKEN == done.json()


def test_an_order_with_the_version_of_a_removed_job_creates_no_job(api):
    problem(api.put("/jobs/never-was", json=HOLDS, headers={"If-Match": '"3"'}), 412)
    problem(api.get("/jobs/never-was"), 404)


def test_repeating_a_finished_order_returns_its_job_even_after_the_world_changed(api, served):
    world = served.services.station.session.world
    with world.transaction("ann", "a place for a while") as tx:
        place = tx.add("kitting:Starter", "short-lived", placement=Placement("sk:in", "pallet_a"))
    goal = [{"not": {"condition": "Holding", "arguments": ["gripper_1", place]}}]
    done = api.put("/jobs/gone", json={"goal": goal}, headers=DONE)
    assert done.json()["outcome"] == "goal already satisfied"
    with world.transaction("ann", "it is gone") as tx:
        tx.remove(place)
    assert api.put("/jobs/gone", json={"goal": goal}).json() == done.json()
    assert problem(api.put("/jobs/gone-2", json={"goal": goal}), 422)["code"] == "UnknownName"


@pytest.mark.parametrize(
    ("order", "code", "more"),
    [
        ({"goal": "InKit(Starter kit_1)"}, "GoalSyntax", {"column": 15}),
        ({"goal": "InKit(Startr, kit_1)"}, "UnknownName", {"nearest": "Starter"}),
        ({"goal": "InKitt(Starter, kit_1)"}, "UnknownName", {"nearest": "InKit"}),
        ({"goal": {"condition": "InKit", "arguments": ["Starter"]}}, "InvalidRequest", {}),
        ({"goal": {"condition": "InKit"}}, "InvalidRequest", {}),
        ({"work_master": "no such"}, "UnknownName", {}),
        ({}, "InvalidRequest", {}),
        ({"goal": "InKit(Starter, kit_1)", "id": "another"}, "InvalidRequest", {}),
        ({"goal": "InKit(Starter, kit_1)", "priority": 1e308}, "InvalidRequest", {}),
        ({"goal": "InKit(\x7f, kit_1)"}, "GoalSyntax", {}),
    ],
)
def test_an_invalid_order_is_refused_with_what_would_be_valid(api, order, code, more):
    refused = problem(api.put("/jobs/wrong", json=order), 422)
    assert refused["code"] == code
    assert more.items() <= refused.items()
    problem(api.get("/jobs/wrong"), 404)


def test_a_structured_goal_equals_its_text(api):
    goal = {"not": {"condition": "Holding", "arguments": ["gripper_1", "Starter"]}}
    job = api.put("/jobs/structured", json={"goal": goal}, headers=DONE).json()
    assert job["order"]["goal"] == ["not (Holding(gripper_1, Starter))"]
    assert job["outcome"] == "goal already satisfied"


@pytest.mark.parametrize("id_", ["line:1;kit?4711#a", "100%", "Ünïcode-漢字", "a+b&c=d", "%2F", "{x}", '"quoted"'])
def test_any_job_id_can_be_used_in_the_url(api, id_):
    job = api.put(f"/jobs/{quote(id_, safe='')}", json={**HOLDS, **LATER})
    assert job.json()["id"] == id_
    assert httpx2.get(api.base_url.join(job.headers["location"])).json() | TAKEN == job.json()
    assert api.post(f"{job.headers['location'].removeprefix('/api/v1')}/cancel").status_code == 200


@pytest.mark.parametrize("id_", ["a b", "a\tb", "x" * 201, "%2E%2E", "job\u202e7", "\u200bjob"])
def test_an_invalid_job_id_is_refused(api, id_):
    answer = api.put(f"/jobs/{id_ if '%' in id_ else quote(id_)}", json=HOLDS)
    assert answer.status_code in (404, 405, 422)
    assert answer.headers["content-type"] == "application/problem+json"


@pytest.mark.parametrize("id_", ["%ff", "%fe", "a%c3"])
def test_an_address_that_is_not_utf_8_is_refused(api, id_):
    assert problem(api.put(f"/jobs/{id_}", json={**HOLDS, **LATER}), 400)["code"] == "InvalidRequest"


@pytest.mark.parametrize(
    ("field", "value"), [("priority", True), ("priority", "5"), ("expires", "yes"), ("expires", 1), ("priority", 5.0)]
)
def test_a_value_of_another_type_is_refused_with_the_name_of_its_field(api, field, value):
    told = problem(api.put("/jobs/typed", json={**HOLDS, **LATER, field: value}), 422)
    assert [one["field"] for one in told["errors"]] == [f"body.{field}"]


@pytest.mark.parametrize(
    ("path", "methods"),
    [
        ("/jobs", {"GET", "POST", "OPTIONS"}),
        ("/jobs/any", {"GET", "PUT", "DELETE", "OPTIONS"}),
        ("/jobs/any/pause", {"POST", "OPTIONS"}),
    ],
)
def test_the_methods_of_an_address_are_listed_by_options_and_by_refusals(api, path, methods):
    listed, refused = api.options(path), api.request("PATCH", path)

    assert (listed.status_code, refused.status_code) == (204, 405)
    for answer in (listed, refused):
        assert set(answer.headers["allow"].split(", ")) == methods


def test_a_full_queue_refuses_new_jobs_and_keeps_the_queued_ones(api, served):
    jobs = served.services.station.session.jobs
    before = jobs.limit
    api.put("/jobs/stands", json={**HOLDS, **LATER}).raise_for_status()
    jobs.limit = 1
    try:
        full = api.put("/jobs/too-much", json={**HOLDS, **LATER})
        assert problem(full, 503)["return_status"] == 1 << 4
        assert int(full.headers["retry-after"]) >= 1
        assert api.put("/jobs/stands", json={**HOLDS, **LATER}).status_code == 200
    finally:
        jobs.limit = before


# ------------------------------------------------------------------ states and commands


def test_a_start_time_and_a_missing_start_permission_are_shown_in_the_state(api):
    assert state(api.put("/jobs/gate", json={**HOLDS, **LATER}).json()) == ("AllowedToStart", ("Waiting",))
    assert state(api.put("/jobs/leave", json=HOLDS, params=STORE).json()) == ("NotAllowedToStart", ("Ready",))


def test_commands_can_be_repeated_and_are_refused_in_states_that_do_not_allow_them(api):
    api.put("/jobs/commands", json={**HOLDS, **LATER}, params=STORE)
    started = api.post("/jobs/commands/start", json={"comment": "go"})
    assert (state(started.json())[0], api.post("/jobs/commands/start").json()) == ("AllowedToStart", started.json())
    revoked = api.post("/jobs/commands/revoke-start")
    assert api.post("/jobs/commands/revoke-start").json() == revoked.json()
    for command in ("pause", "resume", "stop", "clear"):
        refused = problem(api.post(f"/jobs/commands/{command}"), 409)
        assert (refused["code"], refused["return_status"]) == ("InvalidJobOrderStatus", 1 << 3)
    aborted = api.post("/jobs/commands/abort", json={"comment": "not needed"})
    assert (aborted.json()["outcome"], api.post("/jobs/commands/abort").json()) == ("aborted", aborted.json())
    for command in ("start", "revoke-start", "pause", "resume", "stop", "cancel"):
        problem(api.post(f"/jobs/commands/{command}"), 409)
    transitions = api.get("/jobs/commands/transitions").json()["items"]
    assert [one["trigger"] for one in transitions] == ["store", "start", "revoke start", "abort"]
    assert transitions[-1]["comment"] == "local: not needed"
    assert api.post("/jobs/commands/clear").status_code == 200
    problem(api.post("/jobs/commands/clear"), 404)


@pytest.mark.parametrize("command", ["start", "revoke-start", "pause", "resume", "stop", "abort", "cancel", "clear"])
def test_a_command_to_an_unknown_job_is_refused(api, command):
    refused = problem(api.post(f"/jobs/nobody/{command}", json={"comment": "x"}), 404)
    assert (refused["code"], refused["return_status"]) == ("UnknownJobOrderID", 1 << 1)


def test_a_command_with_an_outdated_version_is_refused(api):
    first = api.put("/jobs/stale", json={**HOLDS, **LATER})
    api.post("/jobs/stale/revoke-start")
    refused = problem(api.post("/jobs/stale/start", headers={"If-Match": first.headers["etag"]}), 412)
    assert refused["code"] == "StaleVersion"


def test_removing_a_job_cancels_it_if_queued_and_clears_it_if_finished(api):
    api.put("/jobs/remove", json={**HOLDS, **LATER})
    assert state(api.delete("/jobs/remove").json())[0] == "AllowedToStart"
    problem(api.delete("/jobs/remove"), 404)
    api.put("/jobs/remove-2", json=HOLDS, headers=DONE)
    assert state(api.delete("/jobs/remove-2").json())[0] == "Ended"


def test_the_reason_of_a_command_stays_in_the_audit_log_after_the_job_is_removed(api):
    api.put("/jobs/audited", json=HOLDS | LATER)
    api.post("/jobs/audited/cancel", json={"comment": "the customer went away"})
    newest = api.get("/audit", params={"limit": 1}).json()["items"][0]
    assert (newest["job"], newest["comment"]) == ("audited", "the customer went away")


def test_the_audit_log_names_the_job_that_was_ordered_without_an_id_and_why_one_was_deleted(api):
    job = api.post("/jobs", json=HOLDS | LATER).json()["id"]
    ordered = api.get("/audit", params={"limit": 1}).json()["items"][0]
    api.delete(f"/jobs/{job}", params={"comment": "ordered twice"})
    deleted = api.get("/audit", params={"limit": 1}).json()["items"][0]
    assert (ordered["operation"], ordered["job"]) == ("order_job", job)
    assert (deleted["operation"], deleted["job"], deleted["comment"]) == ("remove_job", job, "ordered twice")


@pytest.mark.parametrize("by", ["cancel", "clear"])
def test_a_late_repeat_of_an_order_does_not_restore_a_removed_job(api, by):
    id_ = f"late-{by}"
    order = HOLDS | (LATER if by == "cancel" else {})
    first = api.put(f"/jobs/{id_}", json=order, headers=DONE if by == "clear" else None).json()
    last = api.post(f"/jobs/{id_}/{by}").json()

    for late in (api.put(f"/jobs/{id_}", json=order), api.post("/jobs", json=order | {"id": id_})):
        told = problem(late, 410)
        assert (told["code"], told["return_status"]) == ("JobOrderRemoved", 16)
        assert (told["last"]["number"], told["last"]["outcome"]) == (first["number"], last["outcome"])
    assert problem(api.put(f"/jobs/{id_}", json=OTHER | LATER), 409)["code"] == "UnableToAcceptJobOrder"
    problem(api.get(f"/jobs/{id_}"), 404)

    meant = api.put(f"/jobs/{id_}", json=OTHER | LATER, params={"again": "true"})
    assert meant.status_code == 202
    assert meant.json()["number"] > first["number"]
    assert api.put(f"/jobs/{id_}", json=OTHER | LATER, params={"again": "true"}).status_code == 200


def test_repeating_an_order_with_start_permission_grants_the_permission(api):
    assert state(api.put("/jobs/stored", json=HOLDS | LATER, params=STORE).json())[0] == "NotAllowedToStart"
    assert state(api.put("/jobs/stored", json=HOLDS | LATER, params=STORE).json())[0] == "NotAllowedToStart"
    assert state(api.put("/jobs/stored", json=HOLDS | LATER).json())[0] == "AllowedToStart"


def test_a_late_repeat_of_an_order_does_not_restore_a_revoked_start_permission(api):
    api.put("/jobs/revoked", json=HOLDS | LATER)
    api.post("/jobs/revoked/revoke-start").raise_for_status()
    assert state(api.put("/jobs/revoked", json=HOLDS | LATER).json())[0] == "NotAllowedToStart"
    assert state(api.post("/jobs/revoked/start").json())[0] == "AllowedToStart"


def test_a_goal_too_large_to_evaluate_is_refused_by_every_operation(api, served):
    variables = "abcdefg"
    declared = ", ".join(f"{variable}: Manipulatable" for variable in variables)
    words = " and ".join(f"InKit({variable}, kit_1)" for variable in variables)
    endless = {"goal": f"for all {declared} (not ({words}))"}
    for answer in (
        api.put("/jobs/endless", json=endless),
        api.post("/jobs", json=endless),
        api.post("/goals/check", json=endless),
        api.post("/previews", json=endless),
    ):
        assert "546875 places to tell whether it holds, and 2000 are allowed" in problem(answer, 422)["detail"]
    problem(api.get("/jobs/endless"), 404)
    with pytest.raises(UsageError, match="546875 places"):
        served.services.station.session.jobs.submit(Order(id="endless", goal=(endless["goal"],)))


def test_an_order_over_the_size_limit_is_refused(api):
    goal = ["LocationEmpty(kit_1_a) or " * 700 + "LocationEmpty(kit_1_b)"] * 4
    assert "65536 are allowed" in problem(api.put("/jobs/long", json={"goal": goal}), 422)["detail"]
    wide = [{"class": "Starter", "id": "x" * 200, "use": "y" * 200}] * 200
    assert "65536 are allowed" in problem(api.put("/jobs/wide", json=HOLDS | {"materials": wide}), 422)["detail"]


def test_ordered_materials_are_returned_unchanged(api):
    wanted = [
        {"class": "Starter", "definition": "ST-4", "lot": "L 7", "quantity": 2, "properties": {"colour": "red"}},
        {"class": "Starter", "quantity": "0.25", "units": "kg", "use": "Consumed"},
    ]
    first = api.put("/jobs/material", json=HOLDS | LATER | {"materials": wanted}).json()["order"]["materials"]
    assert [{key: one[key] for key in said} for one, said in zip(first, wanted, strict=True)] == wanted
    assert api.put("/jobs/material", json=HOLDS | LATER | {"materials": wanted}).status_code == 200
    for quantity in ("0.25", "-1", "one", 0):
        problem(api.put("/jobs/odd", json=HOLDS | {"materials": [{"class": "Starter", "quantity": quantity}]}), 422)


def test_an_order_is_refused_before_its_body_arrives_while_too_many_are_on_their_way(served, api, monkeypatch):
    monkeypatch.setattr("skiros_py.server.access.gate._PATIENCE_WITH_ORDERS", 60.0)  # however slow the machine is
    header = b"PUT /api/v1/jobs/full HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 9\r\n\r\n"
    with crowd(served.url, MOST_WAITING, header) as others, connect(served.url) as one:
        assert api.get("/jobs", params={"limit": 1}).status_code == 200  # those before have begun
        one.sendall(header)
        refused = HTTPResponse(one)
        refused.begin()
        body = refused.read()
        for other in others:
            other.sendall(b"not JSON.")
            assert other.recv(1 << 16).startswith(b"HTTP/1.1 415")
        one.sendall(b"not JSON.GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        assert one.recv(1 << 16).startswith(b"HTTP/1.1 200")  # the connection can be used again

    assert refused.status == 429
    assert refused.headers["Retry-After"] == "1"
    assert json.loads(body)["code"] == "UnableToAcceptJobOrder"
    assert api.put("/jobs/full", json=HOLDS).status_code == 202


def test_an_order_whose_body_does_not_arrive_soon_gives_its_place_up(served, monkeypatch):
    monkeypatch.setattr("skiros_py.server.access.gate._PATIENCE_WITH_ORDERS", 0.1)
    header = b"PUT /api/v1/jobs/hung HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 9\r\n\r\n"
    with connect(served.url, header) as one:
        assert one.recv(1 << 16).startswith(b"HTTP/1.1 408")


def test_orders_whose_clients_wait_for_the_end_are_no_longer_on_their_way(served, api):
    header = b"PUT /api/v1/jobs/later HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 9\r\n\r\n"
    with ThreadPoolExecutor(1) as pool:
        waiting = pool.submit(api.put, "/jobs/slow", json=HOLDS | LATER, headers={"Prefer": "wait=3"})
        until(lambda: api.get("/jobs/slow").status_code == 200)
        with crowd(served.url, MOST_WAITING, header) as others:
            others[-1].sendall(b"not JSON.")
            assert others[-1].recv(1 << 16).startswith(b"HTTP/1.1 415")
            assert not waiting.done()


def test_a_factory_system_can_list_what_it_may_order(api):
    told = api.get("/capabilities").json()
    assert "kitting:Starter" in told["material_class_ids"]
    assert told["equipment_ids"] == ["robot_1"]
    assert told["max_downloadable_job_orders"] == 50_000


def test_accepted_orders_and_commands_have_the_return_status_of_the_standard(api):
    assert api.put("/jobs/status", json=HOLDS | LATER).json()["return_status"] == 1
    assert api.post("/jobs/status/revoke-start").json()["return_status"] == 1
    assert "return_status" not in api.get("/jobs/status").json()
    assert problem(api.post("/jobs/status/pause"), 409)["return_status"] == 8


def test_job_responses_are_listed_by_state_and_page_by_page(api):
    for number in range(3):
        api.put(f"/jobs/done-{number}", json=HOLDS, headers=DONE).raise_for_status()
    seen, cursor = [], "0"
    while cursor is not None:
        page = api.get("/job-responses", params={"state": "Ended", "limit": 2, "cursor": cursor}).json()
        seen, cursor = seen + page["items"], page["next"]
    assert {one["job_state"][0]["text"] for one in seen} == {"Ended"}
    assert [one["job_order_id"] for one in seen][-3:] == ["done-0", "done-1", "done-2"]
    assert all("job_response_data" in one for one in seen)


def test_a_trace_is_read_page_by_page(api):
    api.put("/jobs/traced", json=HOLDS, headers=DONE).raise_for_status()
    whole = api.get("/jobs/traced/trace").json()
    assert (len(whole["items"]) > 1, whole["next"]) == (True, None)
    seen, cursor = [], "0"
    while cursor is not None:
        page = api.get("/jobs/traced/trace", params={"limit": 1, "cursor": cursor}).json()
        seen, cursor = seen + page["items"], page["next"]
    assert seen == whole["items"]


def test_a_job_with_an_open_question_is_held_until_it_is_answered(api, served):
    held = api.put("/jobs/asks", json={**HOPELESS, "policy": {"ask": True}}, headers=DONE).json()
    assert state(held) == ("Interrupted", ("Held",))
    assert "abort" in held["choices"]
    wrong = problem(api.post("/jobs/asks/answer", json={"answer": "abrt"}), 422)
    assert wrong["nearest"] == "abort"
    problem(api.post("/jobs/asks/answer", json={"answer": "abort", "question": held["question"] + 7}), 409)
    answered = api.post("/jobs/asks/answer", json={"answer": "abort", "question": held["question"]})
    assert answered.status_code == 200
    assert over(served, "asks").outcome is Outcome.STOPPED


def test_an_alarm_is_answered_only_with_the_question_that_was_shown(api, served):
    held = api.put("/jobs/alarming", json={**HOPELESS, "policy": {"ask": True}}, headers=DONE).json()
    alarms = api.get("/alarms", params={"active": True}).json()["items"]
    (alarm,) = [alarm for alarm in alarms if alarm["job"] == "alarming"]
    assert alarm["question"] == held["question"]
    later = {"answer": "abort", "question": held["question"] + 7}
    problem(api.post(f"/alarms/{alarm['id']}/answer", json=later), 409)
    problem(api.post(f"/alarms/{alarm['id']}/answer", json={"answer": "abrt"}), 422)
    assert api.get("/jobs/alarming").json()["question"] == held["question"]
    seen = {"answer": "abort", "question": held["question"]}
    assert api.post(f"/alarms/{alarm['id']}/answer", json=seen).status_code == 200
    assert over(served, "alarming").outcome is Outcome.STOPPED
    assert problem(api.post(f"/alarms/{alarm['id']}/answer", json=seen), 409)["code"] == "WrongState"


def test_an_unplannable_goal_is_explained_as_data_and_in_sentences(api):
    job = api.put("/jobs/hopeless", json=HOPELESS, headers=DONE).json()
    assert (state(job)[0], job["outcome"]) == ("Aborted", "no plan")
    explained = api.get("/jobs/hopeless/explanation").json()
    assert explained["reasons"] == job["reasons"]
    assert all(cause["kind"] and cause["conditions"] for cause in explained["causes"])
    assert explained["repairs"]
    assert api.get("/jobs/hopeless/plan").json() == {"items": [], "next": None}


# ------------------------------------------------------------------ lists


def test_jobs_are_listed_page_by_page_and_by_state(api):
    for n in range(5):
        api.put(f"/jobs/page-{n}", json={**HOLDS, **LATER}, params=STORE).raise_for_status()
    found, cursor = [], "0"
    while cursor is not None:
        page = api.get("/jobs", params={"limit": 2, "cursor": cursor, "state": "NotAllowedToStart"}).json()
        assert len(page["items"]) <= 2
        found += [job["id"] for job in page["items"]]
        cursor = page["next"]
    assert [id_ for id_ in found if id_.startswith("page-")] == [f"page-{n}" for n in range(5)]
    assert len(found) == len(set(found))
    assert api.get("/jobs", params={"since": "2099-01-01T00:00:00Z"}).json() == {"items": [], "next": None}


@pytest.mark.parametrize("path", ["/jobs", "/job-responses"])
def test_jobs_are_listed_from_the_newest_backwards_page_by_page(api, path):
    for n in range(3):
        api.put(f"/jobs/back-{n}", json={**HOLDS, **LATER}, params=STORE).raise_for_status()
    whole = api.get(path, params={"limit": 100}).json()["items"]
    seen, query = [], {"limit": 2, "newest_first": True}
    while True:
        page = api.get(path, params=query).json()
        seen += page["items"]
        if page["next"] is None:
            break
        query["cursor"] = page["next"]
    name = "id" if path == "/jobs" else "job_order_id"
    assert [job[name] for job in seen] == [job[name] for job in reversed(whole)]
    assert len(seen) > 3


@pytest.mark.parametrize(
    "query",
    [
        {"state": "Asleep"},
        {"limit": 0},
        {"limit": 1001},
        {"cursor": "x"},
        {"since": "yesterday"},
        {"newest_first": "maybe"},
    ],
)
def test_an_invalid_query_for_jobs_is_refused(api, query):
    problem(api.get("/jobs", params=query), 422)


# ------------------------------------------------------------------ the client


def test_the_client_reads_all_parts_of_a_job(served):
    with Client(served.url) as client:
        job = client.send(Jobs.order(JobOrder(goal="EmptyHanded(gripper_1)"), wait=30))
        assert job.outcome == "goal already satisfied"
        assert client.send(Jobs.get(job.id)) == job
        assert client.send(Jobs.list(states=["Ended"], limit=1000)).items[-1] == job
        assert client.send(Jobs.list(states=["Ended"], limit=1, newest_first=True)).items == [job]
        assert client.send(Jobs.responses(limit=1, newest_first=True)).items[0].job_order_id == job.id
        assert client.send(Jobs.response(job.id)).outcome == job.outcome
        assert client.send(Jobs.plan(job.id)).items == []
        assert client.send(Jobs.report(job.id)).reached
        assert client.send(Jobs.trace(job.id)).items[0]["what"] == "begun"
        assert len(client.send(Jobs.transitions(job.id)).items) == 3
        assert client.send(Jobs.explanation(job.id)).reasons == ()
        assert client.send(Jobs.clear(job.id, seen=job.version)).id == job.id
        kept = client.send(Jobs.put("by-client", JobOrder(goal="EmptyHanded(gripper_1)"), start=False))
        assert kept.state.number == 1
        assert client.send(Jobs.start(kept.id, "go")).state.number in (2, 3, 5)


def test_an_unknown_query_parameter_is_refused_without_ordering_a_job(api):
    answer = problem(api.put("/jobs/mistyped", params={"strt": "false"}, json=HOLDS), 422)

    assert "did you mean 'start'" in answer["detail"].lower()
    assert api.get("/jobs/mistyped").status_code == 404
    assert api.get("/jobs", params={"foo": 1}).status_code == 422
