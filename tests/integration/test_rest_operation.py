"""What those see who keep a server running."""

import threading
from collections.abc import Iterator

import httpx2
import pytest
from prometheus_client.parser import text_string_to_metric_families
from support.serving import Served, serving


@pytest.fixture(scope="module")
def served(tmp_path_factory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as server:
        yield server


def _figures(served: Served) -> dict[str, dict[tuple, float]]:
    text = httpx2.get(f"{served.url}/metrics").raise_for_status().text
    found: dict[str, dict[tuple, float]] = {}
    for family in text_string_to_metric_families(text):
        for sample in family.samples:
            found.setdefault(sample.name, {})[tuple(sorted(sample.labels.items()))] = sample.value
    return found


def test_a_running_server_is_alive_and_ready(served):
    assert httpx2.get(f"{served.url}/healthz").json() == {"alive": True, "why": ""}
    assert httpx2.get(f"{served.url}/readyz").json() == {"ready": True, "halted": False, "why": ""}


def test_requests_are_counted_by_the_template_of_their_path(served):
    for job in ("a", "b", "c"):
        httpx2.get(f"{served.url}/api/v1/jobs/no-such-{job}")
    httpx2.request("BREW", f"{served.url}/api/v1/jobs/x")

    counted = _figures(served)["skiros_http_request_seconds_count"]
    labels = [dict(key) for key in counted]
    assert not [one for one in labels if "no-such" in one["route"]]
    by_route = {(one["method"], one["status"]) for one in labels if one["route"].startswith("/jobs/{")}
    assert ("GET", "404") in by_route
    assert "BREW" not in {one["method"] for one in labels}


def test_the_metrics_follow_the_station(served):
    before = _figures(served)
    session = served.services.station.session
    with session.world.transaction("ann", "for the figures") as tx:
        tx.set("starter_1", "rdfs:label", "another name")
    after = _figures(served)

    assert after["skiros_world_version"][()] == before["skiros_world_version"][()] + 1
    assert after["skiros_cycles_total"][()] > before["skiros_cycles_total"][()]
    assert after["skiros_ready"][()] == 1.0
    assert after["skiros_halted"][()] == 0.0


def test_a_halted_station_is_ready_and_reports_that_it_is_halted(served):
    served.services.station.session.cycle.halt("a test")
    try:
        assert httpx2.get(f"{served.url}/readyz").json()["halted"]
        assert _figures(served)["skiros_halted"][()] == 1.0
    finally:
        served.services.station.control.call(lambda session: session.reset())


def test_a_stuck_control_cycle_is_reported_as_dead_even_if_the_server_answers(tmp_path, monkeypatch):
    monkeypatch.setattr("skiros_py.server.routes.operation._LONGEST_CYCLE", 0.2)
    free = threading.Event()
    with serving("kitting", tmp_path) as server:
        hold = threading.Thread(target=lambda: server.services.station.control.call(lambda _s: free.wait(8.0)))
        hold.start()
        try:
            deadline = 50
            while (response := httpx2.get(f"{server.url}/healthz")).status_code == 200 and deadline:
                deadline -= 1
                free.wait(0.02)
            assert response.status_code == 503
            assert "does not run" in response.json()["why"]
        finally:
            free.set()
            hold.join()
        assert httpx2.get(f"{server.url}/healthz").status_code == 200
