"""Case 17: two hundred slow readers, foreign places, and a server that is killed in between."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import ExitStack, closing
from dataclasses import replace
from itertools import islice
from pathlib import Path
from urllib.parse import urlsplit

import httpx2
import psutil
import pytest
from support.server_process import ServerProcess
from support.serving import Served, serving

from skiros_py.api.events import EventInfo, ResetInfo
from skiros_py.client.streams import follow, stream_events
from skiros_py.server.settings import ServerSettings
from skiros_py.station.events.log import Kind

from .hard import HOLDS, api_of, cycles, over, until

STREAMS = 400  # half of them for one caller


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    settings = replace(ServerSettings(), streams=STREAMS, kept_events=5000)
    with serving("kitting", tmp_path_factory.mktemp("data"), settings=settings) as served:
        yield served


@pytest.fixture(scope="module")
def api(served: Served) -> Iterator[httpx2.Client]:
    with api_of(served) as api:
        yield api


def reader(served: Served, buffer: int = 4096) -> socket.socket:
    """Opens a stream and reads no more than its head."""
    address = urlsplit(served.url)
    one = socket.socket()
    one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
    one.settimeout(30)
    one.connect((address.hostname, address.port))
    one.sendall(b"GET /api/v1/events?kind=job&kind=task HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
    assert one.recv(12) == b"HTTP/1.1 200"
    return one


@pytest.mark.parametrize(("length", "count"), [(1000, 400), (60_000, 50)])
def test_two_hundred_slow_readers_affect_neither_the_job_nor_other_readers(
    served: Served, api: httpx2.Client, length: int, count: int
) -> None:
    events, process = served.services.station.events, psutil.Process()
    with ExitStack() as stack:
        slow = [stack.enter_context(closing(reader(served))) for _ in range(200)]
        before = process.memory_info().rss
        for burst in range(10):
            for _ in range(count):
                events.append(Kind.TASK, "noise", data={"text": "x" * length})
            for one in slow[burst::10]:
                one.recv(512)
        api.put("/jobs/meanwhile", json=HOLDS).raise_for_status()
        assert over(api, "meanwhile")["outcome"] == "goal already satisfied"
        cycles(api)
        grown = process.memory_info().rss - before
    assert grown < 220e6, f"{grown / 1e6:.0f} MB"  # 200 x 4.4 MB, or 200 x 30 MB, would be owed to them
    until(lambda: served.services.streams.open == 0)


def test_a_slow_reader_gets_a_reset_and_still_receives_the_end_of_the_job(served: Served, api: httpx2.Client) -> None:
    with api.sse("/events?kind=job&kind=task") as source:
        first = next(event for event in source if event.id)
    for _ in range(6000):
        served.services.station.events.append(Kind.TASK, "noise")
    api.put("/jobs/gap", json=HOLDS).raise_for_status()
    over(api, "gap")
    items = follow(api, stream_events(kinds=["job"]), after=first.id)
    reset = next(items)
    assert isinstance(reset, ResetInfo)
    assert reset.code == "gone"
    assert "/api/v1/jobs" in reset.read
    assert api.get("/jobs/gap").json()["outcome"] == "goal already satisfied"  # which is there to be read


@pytest.mark.parametrize(
    "place",
    ["", "0", "-1", "1e308", "x" * 60, "00000000-1", "ffffffff-99999999999999999999", "💥".encode().decode("latin-1"),
     "1-2-3", "null", "../../etc/passwd", "-", "%0d%0aSet-Cookie: a=b"],
)  # fmt: skip
def test_no_value_of_last_event_id_breaks_a_stream(api: httpx2.Client, place: str) -> None:
    with api.sse("/events", headers={b"Last-Event-ID": place.encode("latin-1")}) as source:
        first = next(iter(source))
        assert source.response.status_code == 200
        assert "set-cookie" not in source.response.headers
    assert first.event in ("reset", "message", "")


def test_a_reader_receives_the_end_of_its_job_despite_a_kill_of_the_server(tmp_path: Path) -> None:
    port = [0]

    def redirect(request: httpx2.Request) -> None:
        request.url = request.url.copy_with(port=port[0])

    with httpx2.Client(base_url="http://127.0.0.1/api/v1", event_hooks={"request": [redirect]}, timeout=60.0) as api:
        with ServerProcess("kitting", "--fake", data=tmp_path) as server:
            port[0] = urlsplit(server.url).port or 0
            api.put("/jobs/late", json=HOLDS, params={"start": "false"}).raise_for_status()
            items = follow(api, stream_events(kinds=["job"], job="late"), after="00000000-1", patience=60.0)
            assert isinstance(next(items), ResetInfo)
            api.post("/jobs/late/revoke-start")
            api.post("/jobs/late/start").raise_for_status()
            seen = [one.type for one in islice(items, 3) if isinstance(one, EventInfo)]
            server.kill()
        with ServerProcess("--fake", data=tmp_path) as server:
            port[0] = urlsplit(server.url).port or 0
            api.put("/jobs/late-2", json=HOLDS, params={"start": "false"}).raise_for_status()
            after = next(items)
            assert isinstance(after, ResetInfo)
            assert after.code == "restarted"
            assert api.get("/jobs/late").json()["outcome"] == "goal already satisfied"
            items.close()
    assert seen[-1] == "Ended"
