"""A bad network: a proxy in front of a server that loses answers, delays them, and can be aimed at another server."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Coroutine
from typing import Any, Self

_CHUNK = 1 << 16


class BadNetwork:
    """Listens at a port of this machine and passes on what comes to a server.

    Attributes:
        target: Port of the server; None while the line is dead.
        lose: Of so many connections one loses its answer after the request has arrived; 0 for none.
        lost: How many answers were lost.
    """

    def __init__(self) -> None:
        self.target: int | None = None
        self.lose = 0
        self.lost = 0
        self._count = 0
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="bad-network")

    @property
    def url(self) -> str:
        host, port = self._server.sockets[0].getsockname()
        return f"http://{host}:{port}"

    def __enter__(self) -> Self:
        self._thread.start()
        self._server = self._run(asyncio.start_server(self._serve, "127.0.0.1", 0))
        return self

    def __exit__(self, *_: object) -> None:
        self._run(self._end())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def _run(self, work: Coroutine[Any, Any, Any]) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result()

    async def _end(self) -> None:
        self._server.close()
        others = asyncio.all_tasks() - {asyncio.current_task()}
        for task in others:
            task.cancel()
        await asyncio.gather(*others, return_exceptions=True)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._count += 1
        loses = self.lose > 0 and self._count % self.lose == 0
        if self.target is None:
            writer.transport.abort()
            return
        try:
            there, back = await asyncio.open_connection("127.0.0.1", self.target)
        except OSError:
            writer.transport.abort()
            return
        try:
            await asyncio.gather(self._pump(reader, back), self._answer(there, writer, loses=loses))
        except OSError:
            pass  # one of the two has gone
        finally:
            writer.transport.abort()
            back.transport.abort()

    async def _answer(self, there: asyncio.StreamReader, writer: asyncio.StreamWriter, *, loses: bool) -> None:
        if loses:
            await there.read(1)  # the server has done what it was asked for, and says so
            self.lost += 1
            raise ConnectionResetError
        await self._pump(there, writer)

    async def _pump(self, source: asyncio.StreamReader, sink: asyncio.StreamWriter) -> None:
        while data := await source.read(_CHUNK):
            sink.write(data)
            await sink.drain()
        raise ConnectionResetError  # one end has closed: so does the other
