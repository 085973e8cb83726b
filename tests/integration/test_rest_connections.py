"""Clients that hold connections open delay no one else: a stop is answered all the same."""

from __future__ import annotations

import resource
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from support.crowd import HALF, connect, crowd, is_closed, stop
from support.server_process import ServerProcess
from support.serving import Served, serving

from skiros_py.server.settings import ServerSettings
from skiros_py.station.events.log import Kind

from .hard import until

SETTINGS = replace(
    ServerSettings(), connections=120, connections_of_one=100, header_seconds=1.0, idle_seconds=2, stalled_seconds=1.0
)
STREAM = b"GET /api/v1/robots/state/stream?rate=20 HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
EVENTS = b"GET /api/v1/events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
HEALTH = b"GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data"), settings=SETTINGS) as served:
        yield served


@pytest.fixture(scope="module")
def patient(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    settings = replace(SETTINGS, header_seconds=600.0, idle_seconds=600, stalled_seconds=600.0)
    with serving("kitting", tmp_path_factory.mktemp("patient"), settings=settings) as served:
        yield served


@pytest.mark.parametrize("said", [b"", HALF, HALF + b"Content-Le", b"\r\n\r\n", HEALTH[:9]])
def test_a_connection_without_a_complete_header_is_closed(served: Served, said: bytes) -> None:
    with connect(served.url, said) as one:
        assert is_closed(one)


def test_a_header_that_trickles_does_not_extend_its_deadline(served: Served) -> None:
    with connect(served.url, HALF) as one:
        one.settimeout(0.2)
        for _ in range(100):
            try:
                one.sendall(b"X")
                if one.recv(1) == b"":
                    return
            except TimeoutError:
                continue
            except ConnectionError:
                return
    raise AssertionError("it is never closed")


def test_a_request_that_arrives_in_pieces_is_answered(served: Served) -> None:
    with connect(served.url) as one:
        for piece in (HEALTH[:1], HEALTH[1:30], HEALTH[30:-1], HEALTH[-1:] + HEALTH[:20], HEALTH[20:]):
            one.sendall(piece)
            time.sleep(0.01)
        answers = b""
        while answers.count(b"200 OK") < 2:
            answers += one.recv(4096)


def test_what_is_no_request_is_refused_at_once(patient: Served) -> None:
    with connect(patient.url, b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03") as one:  # TLS
        assert one.recv(4096).startswith(b"HTTP/1.1 400")


def test_an_idle_connection_is_closed_after_an_answer(served: Served) -> None:
    with connect(served.url, HEALTH) as one:
        assert b"200 OK" in one.recv(4096)
        assert is_closed(one)


def test_half_a_header_after_an_answer_is_closed(served: Served) -> None:
    with connect(served.url, HEALTH) as one:
        assert b"200 OK" in one.recv(4096)
        one.sendall(HALF)
        assert is_closed(one)


def test_an_endless_header_is_refused(patient: Served) -> None:
    with connect(patient.url, HALF) as one:
        for _ in range(40):
            try:
                one.sendall(b"X-Long: " + b"x" * 16_000 + b"\r\n")
            except ConnectionError:
                return
        assert is_closed(one)


def test_a_reader_that_never_reads_is_disconnected(served: Served) -> None:
    with crowd(served.url, 3, EVENTS, buffer=4096) as readers:
        for one in readers:
            assert one.recv(12) == b"HTTP/1.1 200"
        for _ in range(200):
            served.services.station.events.append(Kind.TASK, "noise", data={"text": "x" * 60_000})
        until(lambda: served.services.streams.open == 0)


def test_too_many_pipelined_requests_end_the_connection(patient: Served) -> None:
    with connect(patient.url, HEALTH * 2000) as one:
        taken = b""
        try:
            while data := one.recv(1 << 16):
                taken += data
        except ConnectionError:
            pass
        assert taken.count(b"HTTP/1.1 200") < 2000


@pytest.mark.parametrize("said", [b"", HALF, HEALTH])
def test_a_newcomer_is_answered_however_many_connections_wait(patient: Served, said: bytes) -> None:
    with crowd(patient.url, 300, said) as many:
        assert stop(patient.url)[0] == 200
        assert is_closed(many[0])  # the oldest made room


def test_idle_connections_make_room_but_not_a_stream(patient: Served) -> None:
    with connect(patient.url, STREAM) as stream:
        assert b"200 OK" in stream.recv(4096)
        with crowd(patient.url, 300):
            assert stop(patient.url)[0] == 200
            assert stream.recv(1 << 16)
            assert stream.recv(1 << 16)


def test_the_stop_is_answered_with_more_half_open_connections_than_the_usual_limit_of_files(tmp_path: Path) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (1024, hard))  # inherited by the server, which raises it
    try:
        server = ServerProcess("kitting", "--fake", data=tmp_path)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    with server, crowd(server.url, 1400):
        assert stop(server.url)[0] == 200


def test_a_server_without_descriptors_closes_an_old_connection_and_goes_on_accepting(tmp_path: Path) -> None:
    with ServerProcess("kitting", "--fake", data=tmp_path) as server:
        resource.prlimit(server.pid, resource.RLIMIT_NOFILE, (200, 200))  # lower than its own limit of connections
        with crowd(server.url, 400):
            assert stop(server.url)[0] == 200
        assert stop(server.url)[0] == 200
