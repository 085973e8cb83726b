"""What the server is compared with: a plain FastAPI application that stores orders in SQLite, several per commit.

It has no access control, no goals, no jobs that run: only a checked body, a durable commit
before the answer, and a list.

    python benchmarks/rest_peer.py FILE PORT
"""

from __future__ import annotations

import asyncio
import json
import sqlite3
import sys
import threading
from queue import Empty, SimpleQueue
from typing import Any

import uvicorn
from fastapi import FastAPI
from pydantic import BaseModel

_Waiting = tuple[str, str, asyncio.Future[None]]


class Order(BaseModel):
    """An order."""

    goal: str
    priority: int = 0


class Accepted(Order):
    """A stored order."""

    id: str


class Store:
    """Orders in a file; a thread commits all that wait, and syncs the file before it answers."""

    def __init__(self, file: str, loop: asyncio.AbstractEventLoop) -> None:
        self._waiting: SimpleQueue[_Waiting] = SimpleQueue()
        self._loop = loop
        self._writer = sqlite3.connect(file, isolation_level=None, check_same_thread=False)
        self._reader = sqlite3.connect(file, isolation_level=None, check_same_thread=False)
        for pragma in ("journal_mode = WAL", "synchronous = FULL"):
            self._writer.execute(f"PRAGMA {pragma}")
        self._writer.execute("CREATE TABLE jobs (id TEXT UNIQUE, data TEXT NOT NULL)")
        threading.Thread(target=self._write, daemon=True).start()

    async def put(self, job: Accepted) -> None:
        """Returns when the order is on disk."""
        stored = self._loop.create_future()
        self._waiting.put((job.id, job.model_dump_json(), stored))
        await stored

    def page(self, after: int, limit: int) -> list[tuple[int, str]]:
        """Returns some orders."""
        sql = "SELECT rowid, data FROM jobs WHERE rowid > ? ORDER BY rowid LIMIT ?"
        return self._reader.execute(sql, (after, limit)).fetchall()

    def _write(self) -> None:
        while True:
            group = [self._waiting.get()]
            try:
                while True:
                    group.append(self._waiting.get_nowait())
            except Empty:
                pass
            self._writer.execute("BEGIN IMMEDIATE")
            rows = [(id_, data) for id_, data, _ in group]
            self._writer.executemany("INSERT OR REPLACE INTO jobs VALUES (?, ?)", rows)
            self._writer.execute("COMMIT")
            self._loop.call_soon_threadsafe(_answer, [stored for *_, stored in group])


def _answer(group: list[asyncio.Future[None]]) -> None:
    for stored in group:
        if not stored.done():
            stored.set_result(None)


async def _main(file: str, port: int) -> None:
    app, store = FastAPI(), Store(file, asyncio.get_running_loop())

    async def put(job_id: str, order: Order) -> Accepted:
        job = Accepted(id=job_id, **order.model_dump())
        await store.put(job)
        return job

    async def jobs(limit: int = 100, cursor: int = 0) -> dict[str, Any]:
        rows = store.page(cursor, limit)
        items = [json.loads(data) for _, data in rows]
        return {"items": items, "next": str(rows[-1][0]) if len(rows) == limit else None}

    async def stop() -> dict[str, bool]:
        return {"halted": True}

    app.post("/api/v1/stop")(stop)
    app.put("/api/v1/jobs/{job_id}", status_code=202)(put)
    app.get("/api/v1/jobs")(jobs)
    config = uvicorn.Config(app, port=port, http="httptools", access_log=False, log_level="warning")
    await uvicorn.Server(config).serve()


if __name__ == "__main__":
    asyncio.run(_main(sys.argv[1], int(sys.argv[2])))
