"""Loads a server and prints the measurements as JSON; a separate process, started by ``rest.py``."""

from __future__ import annotations

import asyncio
import json
import re
import socket
import statistics
import sys
import time
from collections import Counter
from collections.abc import Callable, Coroutine
from datetime import datetime
from typing import Any
from urllib.parse import urlsplit

import httpx2
import psutil
from rest_settings import GOAL

_RATE = 200.0
_TWICE = 10
_CLIENTS = 50
_STUCK = 20
_MARK = "the part of change "
_CHANGES = 20.0
"""Changes of the world per second while events are measured."""


def main() -> int:
    """Runs one part and prints its measurements."""
    part, url, pid, *arguments = sys.argv[1:]
    print(json.dumps(asyncio.run(_PARTS[part](url, psutil.Process(int(pid)), *arguments))))
    return 0


def _client(url: str) -> httpx2.AsyncClient:
    limits = httpx2.Limits(max_connections=100, max_keepalive_connections=100)
    return httpx2.AsyncClient(base_url=url, timeout=60.0, limits=limits, trust_env=False)


def _p99(values: list[float]) -> float:
    return sorted(values)[min(len(values) - 1, int(len(values) * 0.99))]


# ---------------------------------------------------------------------- orders


async def _orders(url: str, _server: psutil.Process, seconds: str) -> dict[str, float]:
    number = int(float(seconds) * _RATE)
    took: list[float] = []
    answers: Counter[int] = Counter()
    async with _client(url) as client:
        bare = [await _bare(client) for _ in range(200)]

        async def order(index: int, due: float) -> None:
            job = f"order-{index}"
            response = await client.put(f"/jobs/{job}", params={"start": "false"}, json={"goal": GOAL})
            took.append((time.perf_counter() - due) * 1e3)
            answers[response.status_code] += 1
            if index % _TWICE == 0:
                again = await client.put(f"/jobs/{job}", params={"start": "false"}, json={"goal": GOAL})
                if again.status_code not in (200, 202):
                    answers[again.status_code] += 1

        begun = time.perf_counter() + 0.5
        async with asyncio.TaskGroup() as group:
            for index in range(number):
                due = begun + index / _RATE
                await asyncio.sleep(max(0.0, due - time.perf_counter()))
                group.create_task(order(index, due))
        spent = time.perf_counter() - begun
        there = await _all_jobs(client)
    ordered = Counter(job for job in there if job.startswith("order-"))
    wrong = sum(abs(ordered[f"order-{index}"] - 1) for index in range(number))
    return {
        "sent": number,
        "p99": _p99(took),
        "median": statistics.median(took),
        "worst": max(took),
        "bare": statistics.median(bare),
        "rate": number / spent,
        "wrong": wrong + sum(n for status, n in answers.items() if status not in (200, 202)),
    }


async def _bare(client: httpx2.AsyncClient) -> float:
    """Returns the latency of the smallest answer that passes the whole stack [ms]."""
    begun = time.perf_counter()
    (await client.get("/jobs", params={"limit": 1})).raise_for_status()
    return (time.perf_counter() - begun) * 1e3


async def _all_jobs(client: httpx2.AsyncClient) -> list[str]:
    found: list[str] = []
    cursor = None
    while True:
        query = {"limit": 1000} | ({"cursor": cursor} if cursor else {})
        page = (await client.get("/jobs", params=query)).raise_for_status().json()
        found += [job["id"] for job in page["items"]]
        cursor = page["next"]
        if cursor is None:
            return found


# ---------------------------------------------------------------------- events


async def _events(url: str, server: psutil.Process, seconds: str) -> dict[str, float]:
    plain = await _listened(url, float(seconds))
    before = server.memory_info().rss
    stuck = [_never_reads(url) for _ in range(_STUCK)]
    beside = await _listened(url, float(seconds))
    memory = server.memory_info().rss / before
    for one in stuck:
        one.close()
    return {
        "p99": _p99(plain[0]),
        "median": statistics.median(plain[0]),
        "events": plain[1],
        "missing": plain[2] + beside[2],
        "p99_stuck": _p99(beside[0]),
        "memory": memory,
    }


async def _listened(url: str, seconds: float) -> tuple[list[float], int, int]:
    """Lets 50 clients listen while the world changes; returns latencies [ms], events for each, missing events."""
    late: list[float] = []
    heard: Counter[int] = Counter()
    changes = int(seconds * _CHANGES)
    ready = asyncio.Barrier(_CLIENTS + 1)

    async def listen(client: httpx2.AsyncClient, number: int) -> None:
        async with client.stream("GET", "/events", params={"kind": "world"}) as response:
            response.raise_for_status()
            await ready.wait()
            async for line in response.aiter_lines():
                now = time.time()
                if not line.startswith("data:") or _MARK not in line:  # robots at work change the world, too
                    continue
                at = datetime.fromisoformat(json.loads(line[5:])["at"])
                late.append((now - at.timestamp()) * 1e3)
                heard[number] += 1
                if heard[number] == changes:
                    return

    async with _client(url) as client, _client(url) as writer:
        listeners = [asyncio.create_task(listen(client, number)) for number in range(_CLIENTS)]
        await ready.wait()
        await _change(writer, changes, _CHANGES)
        await asyncio.wait(listeners, timeout=5.0)
        for one in listeners:
            one.cancel()
        await asyncio.gather(*listeners, return_exceptions=True)
    return late, changes, sum(changes - heard[number] for number in range(_CLIENTS))


async def _change(client: httpx2.AsyncClient, changes: int, rate: float) -> None:
    """Changes the label of a part a number of times."""
    begun = time.perf_counter()
    for index in range(changes):
        await asyncio.sleep(max(0.0, begun + index / rate - time.perf_counter()))
        response = await client.patch(
            "/elements/starter_1", json={"label": f"{_MARK}{index}"}, headers={"If-Match": "*"}
        )
        response.raise_for_status()


def _never_reads(url: str) -> socket.socket:
    parts = urlsplit(url)
    assert parts.hostname is not None
    connection = socket.create_connection((parts.hostname, parts.port))
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    connection.sendall(f"GET {parts.path}/events HTTP/1.1\r\nHost: {parts.netloc}\r\n\r\n".encode())
    return connection


# ---------------------------------------------------------------------- memory


async def _jobs(url: str, server: psutil.Process, first: str, last: str) -> dict[str, float]:
    """Runs jobs whose goal holds already."""
    async with _client(url) as client:
        for index in range(int(first), int(last)):
            body = {"goal": "EmptyHanded(gripper_1)"}
            (await client.put(f"/jobs/done-{index}", json=body)).raise_for_status()
        while (await client.get(f"/jobs/done-{int(last) - 1}")).json()["state"]["text"] != "Ended":
            await asyncio.sleep(0.1)
    await asyncio.sleep(2.0)
    return {"memory": server.memory_info().rss / 2**20}


async def _changes(url: str, server: psutil.Process, events: str) -> dict[str, float]:
    """Changes the world until a number of events has occurred."""
    async with _client(url) as client:
        while (number := await _last_event(client)) < int(events):
            await _change(client, min(2000, int(events) - number), 1e9)
    return {"memory": server.memory_info().rss / 2**20, "events": number}


async def _last_event(client: httpx2.AsyncClient) -> int:
    """Returns the number of events since the start of the server."""
    figures = (await client.get(f"{str(client.base_url).split('/api/')[0]}/metrics")).raise_for_status().text
    found = re.search(r"^skiros_events_total (\S+)$", figures, re.MULTILINE)
    assert found is not None
    return int(float(found[1]))


_PARTS: dict[str, Callable[..., Coroutine[Any, Any, dict[str, float]]]] = {
    "orders": _orders,
    "events": _events,
    "jobs": _jobs,
    "changes": _changes,
}

if __name__ == "__main__":
    raise SystemExit(main())
