"""Events over a real server: complete, in order, resumable; slow and dead readers cost nobody anything."""

import asyncio
import gc
import json
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager
from itertools import islice
from pathlib import Path

import httpx2
import pytest
from support.server_process import ServerProcess
from support.serving import serving

from skiros_py.api.events import EventInfo, ResetInfo
from skiros_py.api.jobs import JobState
from skiros_py.client.request import ProblemError, Unreachable
from skiros_py.client.streams import follow, follow_later, stream_events, stream_job_events
from skiros_py.server.access.roles import Role
from skiros_py.server.settings import ServerSettings
from skiros_py.server.streams import position_text
from skiros_py.station.events.log import Kind
from skiros_py.tasks.jobs.job import JobOrder
from skiros_py.world.change import Writer
from skiros_py.world.element import Placement
from skiros_py.world.vocabulary import IN, LABEL, TAUGHT_POSE

KEPT = 5000
STREAMS = 20


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    with serving(
        "kitting", tmp_path_factory.mktemp("data"), settings=ServerSettings(kept_events=KEPT, streams=STREAMS)
    ) as s:
        yield s


@pytest.fixture
def http(served):
    with httpx2.Client(base_url=f"{served.url}/api/v1") as http:
        yield http


def now(http):
    """Returns the place in the log at this moment."""
    after = None
    while True:
        page = http.get("/events/recent", params={"limit": 1000} | ({"after": after} if after else {})).json()
        after = page["next"]
        if len(page["items"]) < 1000:
            return after


def rename(served, element, label):
    with served.services.station.session.world.transaction("anna", "a test", writer=Writer.PERSON) as tx:
        tx.set(element, LABEL, label)


def run_job(served, id_, goal="InKit(Starter, kit_1)"):
    """Orders a job, and waits for its end."""
    jobs, over = served.services.station.session.jobs, threading.Event()
    end = jobs.subscribe(lambda job: job.id == id_ and not job.state.is_open and over.set())
    jobs.submit(JobOrder(id=id_, goal=(goal,)))
    assert over.wait(60)
    end()


# ---------------------------------------------------------------------- what is told


def test_a_world_change_is_an_event_with_author_and_edits(served, http):
    after = now(http)
    rename(served, "kit_1", "the kit")
    (event,) = islice(follow(http, stream_events(kinds=["world"], element="kit_1"), after=after), 1)
    assert (event.kind, event.type) == ("world", "scene")
    assert event.data["author"] == "anna"
    assert event.data["edits"][0]["new"] == "the kit"


def test_learned_facts_have_their_own_event_type(served, http):
    after = now(http)
    with served.services.station.session.world.transaction("anna", "taught", writer=Writer.PERSON) as tx:
        tx.add(TAUGHT_POSE, "a lesson", learned=True)
    (event,) = islice(follow(http, stream_events(kinds=["world"]), after=after), 1)
    assert event.type == "learned"


def test_a_large_change_is_an_event_with_the_first_edits_and_a_link_to_the_rest(served, http):
    after = now(http)
    with served.services.station.session.world.transaction("anna", "many parts", writer=Writer.PERSON) as tx:
        parts = [tx.add("kitting:Starter", placement=Placement(IN, "pallet_a")) for _ in range(200)]
    (event,) = islice(follow(http, stream_events(kinds=["world"], element=parts[-1]), after=after), 1)
    assert len(event.data["edits"]) == 100
    assert event.data["all_edits"] >= 200
    assert http.get(event.data["read"].removeprefix("/api/v1")).status_code == 200
    with served.services.station.session.world.transaction("anna", "enough of them", writer=Writer.PERSON) as tx:
        for part in parts:
            tx.remove(part)


def test_the_events_of_a_job_cover_its_order_all_steps_and_its_end(served, http):
    run_job(served, "told")
    seen = []
    for event in follow(http, stream_job_events("told")):
        assert event.job == "told"
        if event.kind == "job":
            assert JobState.model_validate(event.data["state"]).text == event.type
        seen.append((event.kind, event.type))
        if event.type == "Ended" and event.kind == "job":
            break
    states = [type_ for kind, type_ in seen if kind == "job"]
    assert states[0] == "AllowedToStart"
    assert states[-1] == "Ended"
    happenings = [type_ for kind, type_ in seen if kind == "task"]
    assert [happenings[0], happenings[1], happenings[-1]] == ["begun", "planned", "finished"]
    assert happenings.count("started") == happenings.count("ended") == 4


def test_module_events_name_their_job_and_the_implementation_of_the_skill(served, http):
    after = now(http)
    run = http.post("/modules/arm_1/confirm/runs", json={"arguments": {"question": "Is it so?"}}).json()
    run_job(served, "moved", "RobotAtLocation(robot_1, pallet_a)")
    http.post(f"/module-runs/{run['id']}/stop").raise_for_status()
    told = http.get("/events/recent", params={"kind": "module", "after": after, "limit": 1000}).json()["items"]
    own = [event for event in told if event["job"] == "moved"]
    labels = {way["label"] for way in http.get("/modules/base_1/drive").json()["implementations"]}

    assert [event["subject"] for event in own if event["data"]["caller"] == ""][:1] == ["drive"]
    assert {event["data"]["task"] for event in own} == {"moved"}
    assert {event["data"]["implementation"] for event in own if event["data"]["kind"] == "skill"} <= labels
    assert {event["data"]["task"] for event in told if event["subject"] == "confirm"} == {""}
    assert not any(event["job"] for event in told if event["subject"] == "confirm")


def test_events_of_an_unknown_job_are_answered_with_404(http):
    response = http.get("/jobs/never/events")
    assert (response.status_code, response.json()["code"]) == (404, "UnknownJobOrderID")


# ---------------------------------------------------------------------- resuming


def test_each_page_of_events_continues_where_the_previous_one_ended(served, http):
    after = now(http)
    for n in range(25):
        rename(served, "kit_1", f"kit {n}")
    labels = []
    for _ in range(3):
        page = http.get("/events/recent", params={"after": after, "limit": 10, "kind": "world"}).json()
        labels += [item["data"]["edits"][0]["new"] for item in page["items"]]
        after = page["next"]
    assert labels == [f"kit {n}" for n in range(25)]
    assert page["reset"] is None


@pytest.mark.parametrize("header", [True, False])
def test_a_stream_resumes_after_the_last_received_event(served, http, header):
    after = now(http)
    for n in range(3):
        rename(served, "kit_1", f"resumed {n} {header}")
    asked = {"headers": {"Last-Event-ID": after}} if header else {"params": {"after": after}}
    with http.sse("/events", **asked) as source:
        told = [event.json() for event in islice((e for e in source if e.event == "world"), 3)]
    assert [one["data"]["edits"][0]["new"] for one in told] == [f"resumed {n} {header}" for n in range(3)]


@pytest.mark.parametrize(
    ("given", "code"),
    [("0000aaaa-3", "restarted"), ("garbage", "unknown"), ("%00%ff", "unknown"), ("{epoch}-999999", "future")],
)
def test_an_unknown_position_gets_a_reset_and_then_new_events(served, http, given, code):
    place = given.format(epoch=served.services.station.events.epoch)
    items = follow(http, stream_events(kinds=["world"]), after=place)
    reset = next(items)
    rename(served, "kit_1", f"after {place}"[:20])
    assert isinstance(reset, ResetInfo)
    assert (reset.code, next(items).data["edits"][0]["new"]) == (code, f"after {place}"[:20])
    page = http.get("/events/recent", params={"after": place}).json()
    assert (page["items"], page["reset"]["code"]) == ([], code)


def test_a_position_whose_events_are_gone_gets_a_reset(served, http):
    after = now(http)
    for _ in range(KEPT + 1):
        served.services.station.events.append(Kind.SYSTEM, "reset")
    (reset,) = islice(follow(http, stream_events(), after=after), 1)
    assert reset.code == "gone"


# ---------------------------------------------------------------------- who may, and how many


@pytest.mark.parametrize("query", ["kind=weather", "limit=0", "limit=1001", "after=" + "x" * 200, "job=" + "x" * 300])
def test_an_invalid_query_for_recent_events_is_refused(http, query):
    assert http.get(f"/events/recent?{query}").status_code == 422


def test_streams_over_the_limit_are_refused_until_others_are_closed(served, http):
    sockets = [_open(served, "/api/v1/events") for _ in range(STREAMS // 2)]
    response = http.get("/events")
    assert (response.status_code, response.json()["code"]) == (503, "Busy")
    assert int(response.headers["retry-after"]) > 0
    for one in sockets:
        one.close()
    _until(lambda: served.services.streams.open == 0)
    with http.sse("/events") as source:
        assert next(iter(source)).id


def _open(served, path):
    """Opens a stream and reads where it begins: what happens from then on is told."""
    host, port = served.url.removeprefix("http://").split(":")
    one = socket.create_connection((host, int(port)), timeout=20)
    one.sendall(f"GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n".encode())
    head = b""
    while b"retry: " not in head:  # the first thing that a stream says
        head += one.recv(4096)
    assert head.startswith(b"HTTP/1.1 200")
    return one


def _until(reached, patience=30.0):
    deadline = time.monotonic() + patience
    while not reached():
        assert time.monotonic() < deadline, "it was never reached"
        time.sleep(0.005)


def test_a_stream_ends_when_its_key_is_revoked_and_cannot_be_reopened(tmp_path):
    with serving("kitting", tmp_path, settings=ServerSettings(authentication="keys")) as served:
        keys = served.services.keys
        keys.create("chief", Role.ADMIN)
        key, text = keys.create("panel", Role.VIEWER)
        http = httpx2.Client(base_url=f"{served.url}/api/v1", headers={"Authorization": f"Bearer {text}"})
        with http, ThreadPoolExecutor(1) as pool:
            items = follow(http, stream_events())
            following = pool.submit(list, items)
            _until(lambda: served.services.streams.open == 1)
            keys.revoke(key.id)
            with pytest.raises(ProblemError) as refused:
                following.result(60)
        assert refused.value.status == 401
        assert served.services.streams.open == 0


def test_a_factory_system_receives_jobs_and_alarms_and_other_events_only_of_its_jobs(tmp_path):
    with serving("kitting", tmp_path, settings=ServerSettings(authentication="keys")) as served:
        _, text = served.services.keys.create("mes", Role.MES)
        with httpx2.Client(base_url=f"{served.url}/api/v1", headers={"Authorization": f"Bearer {text}"}) as http:
            rename(served, "kit_1", "the kit")
            run_job(served, "a")
            page = http.get("/events/recent", params={"limit": 1000}).json()
            assert {one["kind"] for one in page["items"]} == {"job", "system"}
            of_job = http.get("/events/recent", params={"limit": 1000, "job": "a"}).json()
            assert {one["kind"] for one in of_job["items"]} == {"job", "task", "module"}
            assert http.get("/events/recent", params={"kind": "world"}).status_code == 403


# ---------------------------------------------------------------------- adversarial readers


def _resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def test_a_client_that_never_reads_does_not_affect_others(served, http):
    """100,000 events of 1 kB pass by it; what it does not take is not kept for it."""
    events, bursts, each = served.services.station.events, 50, 2000
    text = "x" * 1000
    with (
        closing(_open(served, "/api/v1/events?kind=task")),
        closing(_open(served, "/api/v1/events?kind=task")) as reader,
    ):
        seen = [0]
        thread = threading.Thread(target=_count, args=(reader, seen))
        thread.start()
        gc.collect()
        before = _resident()
        for burst in range(1, bursts + 1):
            for _ in range(each):
                events.append(Kind.TASK, "noise", data={"text": text})
            _until(lambda wanted=burst * each: seen[0] >= wanted)
        grown = _resident() - before
        assert seen[0] == bursts * each  # the reader missed nothing
        reader.shutdown(socket.SHUT_RD)
        thread.join()
    assert grown < 40e6, f"{grown / 1e6:.0f} MB"  # the log keeps 6 MB of these, and the silent one would be owed 130 MB


def _count(reader, seen):
    """Counts events as they come."""
    rest = b""
    while chunk := reader.recv(1 << 20):
        rest += chunk
        seen[0] += rest.count(b"\ndata: ")
        rest = rest[-6:] if not rest.endswith(b"\ndata: ") else b""


def test_fifty_readers_get_every_event_in_order(tmp_path):
    with serving("kitting", tmp_path, settings=ServerSettings(streams=100)) as served:
        events = served.services.station.events
        url, after = f"{served.url}/api/v1", position_text(events, events.last)

        def read(_):
            with httpx2.Client(base_url=url) as http, http.sse(f"/events?kind=task&after={after}") as source:
                told = (event for event in source if event.data)
                return [event.json()["data"]["n"] for event in islice(told, 100)]

        with ThreadPoolExecutor(50) as pool:
            readers = [pool.submit(read, n) for n in range(50)]
            for n in range(100):
                events.append(Kind.TASK, "noise", data={"n": n})
            assert all(reader.result(60) == list(range(100)) for reader in readers)


def test_streams_end_at_once_when_the_server_shuts_down(tmp_path):
    ended = threading.Event()

    def read(url):
        with httpx2.Client(base_url=f"{url}/api/v1", timeout=60) as http, http.sse("/events") as source:
            list(source)
        ended.set()

    with serving("kitting", tmp_path) as served:
        thread = threading.Thread(target=read, args=(served.url,))
        thread.start()
        _until(lambda: served.services.streams.open == 1)
        served.services.streams.end()
        assert ended.wait(20)
        thread.join()


# ---------------------------------------------------------------------- the robots' state


def test_the_live_state_contains_the_activity_of_the_robots(http):
    state = http.get("/state").json()
    robot = http.get("/robots/robot_1/state").json()
    assert len(state["devices"]["arm_1"]["state"]["positions"]) == 7
    assert state["devices"]["gripper_1"]["holds"] is None
    assert set(state["platforms"]["base_1"]) == {"position", "orientation"}
    assert (state["devices"], state["frames"]["arm_1"]) == (robot["devices"], robot["frames"]["arm_1"])
    assert (state["halted"], state["tasks"], state["modules"]) == ("", [], [])


def test_the_state_stream_has_no_event_ids_because_it_is_never_replayed(http):
    with http.sse("/robots/state/stream?rate=20") as source:
        first, second = islice(source, 2)
    assert (first.event, first.id) == ("state", "")
    assert json.loads(first.data)["cycle"] < json.loads(second.data)["cycle"]


def test_the_live_state_is_built_once_for_all_readers_and_never_without_readers(served, http):
    live = served.services.station.live
    before = live.built
    time.sleep(0.2)
    assert live.built == before
    with ThreadPoolExecutor(8) as pool:

        def look(_):
            with (
                httpx2.Client(base_url=f"{served.url}/api/v1") as own,
                own.sse("/robots/state/stream?rate=20") as source,
            ):
                return len(list(islice(source, 10)))

        assert list(pool.map(look, range(8))) == [10] * 8
    assert live.built - before < 40  # and not 80


# ---------------------------------------------------------------------- the client


def test_the_client_continues_after_a_server_restart_and_is_notified_of_the_gap(tmp_path):
    port = [0]

    def redirect(request):
        request.url = request.url.copy_with(port=port[0])

    with httpx2.Client(base_url="http://127.0.0.1/api/v1", event_hooks={"request": [redirect]}) as http:
        box = []

        def read(items):
            for item in islice(items, 2):
                box.append(item)  # noqa: PERF402 - one by one, for those who look

        with serving("kitting", tmp_path) as served:
            port[0] = httpx2.URL(served.url).port
            after = position_text(served.services.station.events, served.services.station.events.last)
            items = follow(http, stream_events(kinds=["world"]), after=after, patience=60.0)
            thread = threading.Thread(target=read, args=(items,))
            thread.start()
            rename(served, "kit_1", "before")
            _until(lambda: box)
        with serving("kitting", tmp_path) as served:
            port[0] = httpx2.URL(served.url).port
            thread.join(60)
        first, second = box
        assert isinstance(first, EventInfo)
        assert first.data["edits"][0]["new"] == "before"
        assert isinstance(second, ResetInfo)
        assert second.code == "restarted"


def test_a_killed_server_notifies_its_clients_of_the_gap_and_what_to_read_and_continues(tmp_path):
    def stream(http, last):
        return http.sse("/events?kind=world", headers={"Last-Event-ID": last})

    def rename_by_request(http, label):
        http.patch("/elements/kit_1", json={"label": label}, headers={"If-Match": "*"}).raise_for_status()

    with (
        ServerProcess("kitting", "--fake", data=tmp_path) as server,
        httpx2.Client(base_url=f"{server.url}/api/v1", timeout=30) as http,
    ):
        with stream(http, "") as source:
            frames = iter(source)
            rename_by_request(http, "before")
            last = next(frame.id for frame in frames if frame.event == "world")
        server.kill()
    with (
        ServerProcess("--fake", data=tmp_path) as server,
        httpx2.Client(base_url=f"{server.url}/api/v1", timeout=30) as http,
    ):
        with stream(http, last) as source:
            frames = iter(source)
            reset = next(frames)
            assert (reset.event, json.loads(reset.data)["code"]) == ("reset", "restarted")
            for path in json.loads(reset.data)["read"]:
                assert http.get(path.removeprefix("/api/v1")).status_code == 200
            assert http.get("/elements/kit_1").json()["label"] == "before"
            rename_by_request(http, "after")
            told = next(frames)
        assert json.loads(told.data)["data"]["edits"][0]["new"] == "after"
        with stream(http, reset.id) as source:  # a client that was cut off right after the reset
            assert next(frame.id for frame in source if frame.event == "world") == told.id


def test_a_broken_connection_is_restored_without_lost_or_repeated_events(served, http):
    """A go-between cuts the connection every few hundred bytes."""
    with _cutting(served, every=900) as url, httpx2.Client(base_url=f"{url}/api/v1") as shaky:
        items = follow(shaky, stream_events(kinds=["task"]), after=now(http))
        for n in range(40):
            served.services.station.events.append(Kind.TASK, "noise", data={"n": n})
        assert [event.data["n"] for event in islice(items, 40)] == list(range(40))
        items.close()


def test_the_client_gives_up_without_an_answer_and_names_the_server_address():
    with (
        httpx2.Client(base_url="http://127.0.0.1:9/api/v1") as http,
        pytest.raises(Unreachable, match=r"127\.0\.0\.1:9"),
    ):
        next(follow(http, stream_events(), patience=0.1))


def test_a_refusal_by_the_server_is_raised_in_the_client(http):
    with pytest.raises(ProblemError, match="never"):
        next(follow(http, stream_job_events("never")))


def test_the_asynchronous_client_follows_events_too(served):
    async def run():
        async with httpx2.AsyncClient(base_url=f"{served.url}/api/v1") as http:
            items = follow_later(
                http, stream_events(kinds=["world"]), after=position_text(served.services.station.events, 0)
            )
            first = await anext(items)
            asyncio.get_running_loop().call_later(0.1, rename, served, "kit_1", "for later")
            async for event in items:
                if isinstance(event, EventInfo) and event.data["edits"][0].get("new") == "for later":
                    break
            await items.aclose()
            return first

    assert asyncio.run(asyncio.wait_for(run(), 60)) is not None


@contextmanager
def _cutting(served, every):
    """Passes connections on to the server, and cuts each after so many bytes of the answer."""
    target = httpx2.URL(served.url)
    ended = threading.Event()

    def pass_on(client):
        with closing(client), closing(socket.create_connection((target.host, target.port))) as server:
            server.settimeout(0.5)
            server.sendall(client.recv(65536))
            left = every
            while left > 0 and not ended.is_set():
                try:
                    chunk = server.recv(left)
                except TimeoutError:
                    continue
                if not chunk:
                    return
                left -= len(chunk)
                client.sendall(chunk)

    def accept(listening):
        while not ended.is_set():
            try:
                client, _ = listening.accept()
            except TimeoutError:
                continue
            threading.Thread(target=pass_on, args=(client,), daemon=True).start()

    with closing(socket.create_server(("127.0.0.1", 0))) as listening:
        listening.settimeout(0.2)
        thread = threading.Thread(target=accept, args=(listening,))
        thread.start()
        try:
            yield f"http://127.0.0.1:{listening.getsockname()[1]}"
        finally:
            ended.set()
            thread.join()
