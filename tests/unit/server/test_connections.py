"""A connection costs little until its client has sent a complete header."""

from __future__ import annotations

import asyncio
import socket
import time
from collections.abc import Awaitable, Callable, Iterator
from contextlib import ExitStack, closing
from dataclasses import replace

import pytest

from skiros_py.server.connections import Connections, Newcomer
from skiros_py.server.settings import ServerSettings

HALF, REST = b"GET /healthz HTTP/1.1\r\nHost: a\r\n", b"\r\n"
STOP = b"POST /api/v1/stop HTTP/1.1\r\nHost: a\r\nContent-Length: 0\r\n\r\n"


class Clients:
    """Clients of a listening socket, and the newcomers that were given a protocol, which takes a time [s]."""

    def __init__(self, stack: ExitStack) -> None:
        self._stack = stack
        self.listening = stack.enter_context(closing(socket.create_server(("127.0.0.1", 0))))
        self.served: list[Newcomer] = []
        self.takes = 0.0

    def connect(self, said: bytes = b"") -> socket.socket:
        """Opens a connection and sends something."""
        one = self._stack.enter_context(socket.create_connection(self.listening.getsockname()))
        one.setblocking(False)
        one.sendall(said)
        return one

    def run(self, settings: ServerSettings, act: Callable[[Connections], Awaitable[None]]) -> None:
        """Accepts connections while a function runs."""

        transports: list[asyncio.BaseTransport] = []

        class Protocol(asyncio.Protocol):
            def connection_made(self, transport: asyncio.BaseTransport) -> None:
                transports.append(transport)

        def make(newcomer: Newcomer) -> asyncio.Protocol:
            self.served.append(newcomer)
            time.sleep(self.takes)
            return Protocol()

        async def run() -> None:
            connections = Connections(settings)
            connections.listen(self.listening, make)  # type: ignore[arg-type]
            try:
                await act(connections)
            finally:
                connections.close()
                await asyncio.sleep(0.01)
                for transport in transports:
                    transport.close()
                await asyncio.sleep(0)

        asyncio.run(run())

    async def until_served(self, number: int) -> None:
        """Waits until as many newcomers have a protocol."""
        async with asyncio.timeout(30.0):
            while len(self.served) < number:
                await asyncio.sleep(0.001)


@pytest.fixture
def clients() -> Iterator[Clients]:
    with ExitStack() as stack:
        yield Clients(stack)


def test_a_connection_gets_a_protocol_only_with_a_complete_header(clients: Clients) -> None:
    async def act(_connections: Connections) -> None:
        many = [clients.connect(HALF) for _ in range(100)]
        clients.connect(HALF + REST)
        await clients.until_served(1)
        assert [bytes(one.received) for one in clients.served] == [HALF + REST]
        many[7].sendall(REST[:1])
        many[8].sendall(REST)
        await clients.until_served(2)
        assert bytes(clients.served[1].received) == HALF + REST

    clients.run(ServerSettings(), act)


@pytest.mark.parametrize("end", [b"\r\n\r\n", b"\n\n", b"\r\n\n"])
def test_the_end_of_a_header_is_found_in_any_pieces(clients: Clients, end: bytes) -> None:
    async def act(_connections: Connections) -> None:
        one = clients.connect()
        for byte in b"GET / HTTP/1.1" + end:
            assert not clients.served
            one.sendall(bytes([byte]))
            await asyncio.sleep(0.002)
        await clients.until_served(1)

    clients.run(ServerSettings(), act)


@pytest.mark.parametrize("said", [b"\x16\x03\x01\x02", b"get / http", b"GET /" + b"x" * (64 << 10)])
def test_what_is_no_header_is_left_to_the_protocol_which_refuses_it(clients: Clients, said: bytes) -> None:
    async def act(_connections: Connections) -> None:
        one = clients.connect()
        one.setblocking(True)
        await asyncio.to_thread(one.sendall, said)
        await clients.until_served(1)

    clients.run(ServerSettings(), act)


def test_a_stop_is_answered_before_requests_that_came_earlier(clients: Clients) -> None:
    async def act(_connections: Connections) -> None:
        for _ in range(50):
            clients.connect(HALF + REST)
        clients.connect(STOP)
        await clients.until_served(51)
        assert [bytes(one.received) for one in clients.served] == [STOP, *[HALF + REST] * 50]

    clients.run(ServerSettings(), act)


def test_a_client_that_has_sent_its_header_is_not_late_because_the_server_is(clients: Clients) -> None:
    clients.takes = 0.02

    async def act(_connections: Connections) -> None:
        for _ in range(80):
            clients.connect(HALF + REST)
        await clients.until_served(80)

    clients.run(replace(ServerSettings(), header_seconds=0.1), act)


def test_connections_without_a_header_are_closed_for_newer_ones_and_at_the_end(clients: Clients) -> None:
    ended: list[bytes] = []

    async def act(_connections: Connections) -> None:
        loop = asyncio.get_running_loop()
        many = [clients.connect(HALF) for _ in range(11)]
        ended.append(await asyncio.wait_for(loop.sock_recv(many[0], 1), 30.0))
        many[1].sendall(REST)
        await clients.until_served(1)
        last.append(many[2])

    last: list[socket.socket] = []
    clients.run(replace(ServerSettings(), connections_of_one=10), act)
    last[0].setblocking(True)
    assert (ended, last[0].recv(1)) == ([b""], b"")
