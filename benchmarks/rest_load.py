"""Loads a server and prints the measurements as JSON; a separate process, started by ``rest.py``."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import re
import resource
import socket
import statistics
import sys
import time
import uuid
from collections import Counter
from collections.abc import Callable, Coroutine
from datetime import datetime
from typing import Any
from urllib.parse import urlsplit

import httpx2
import psutil
from rest_settings import GOAL

_REFUSED = 429
_TWICE = 10
_CLIENTS = 50
_STUCK = 20
_HALF_OPEN, _SLOW, _STOPS = 1300, 200, 30
_MARK = "the part of change "
_CHANGES = 20.0
"""Changes of the world per second while events are measured."""


def main() -> int:
    """Runs one part and prints its measurements."""
    part, url, pid, *arguments = sys.argv[1:]
    print(json.dumps(asyncio.run(_PARTS[part](url, psutil.Process(int(pid)), *arguments))))
    return 0


def _client(url: str, connections: int = 100) -> httpx2.AsyncClient:
    limits = httpx2.Limits(max_connections=connections, max_keepalive_connections=connections)
    return httpx2.AsyncClient(base_url=url, timeout=60.0, limits=limits, trust_env=False)


def _p99(values: list[float]) -> float:
    return sorted(values)[min(len(values) - 1, int(len(values) * 0.99))]


# ---------------------------------------------------------------------- orders


async def _orders(url: str, server: psutil.Process, seconds: str, flight: str) -> dict[str, float]:
    """Keeps a number of orders in flight; each tenth is sent twice."""
    took: list[float] = []
    refused: list[float] = []
    answers: Counter[int] = Counter()
    accepted: list[str] = []
    async with _client(url, int(flight)) as client:
        bare = [await _bare(client) for _ in range(200)]
        run, numbers = uuid.uuid4().hex, itertools.count()
        begun = time.perf_counter()

        async def put(job: str) -> None:
            sent = time.perf_counter()
            response = await client.put(f"/jobs/{job}", params={"start": "false"}, json={"goal": GOAL})
            spent = (time.perf_counter() - sent) * 1e3
            if response.status_code == _REFUSED and "Retry-After" in response.headers:
                refused.append(spent)
                return
            answers[response.status_code] += 1
            took.append(spent)
            accepted.append(job)

        async def keep_ordering() -> None:
            while time.perf_counter() < begun + float(seconds):
                number = next(numbers)
                for _ in range(2 if number % _TWICE == 0 else 1):
                    await put(f"order-{run}-{number}")

        before = sum(server.cpu_times()[:2])
        await asyncio.gather(*(keep_ordering() for _ in range(int(flight))))
        spent = time.perf_counter() - begun
        cpu = sum(server.cpu_times()[:2]) - before
        there = Counter(job for job in await _all_jobs(client) if run in job)
    wrong = sum(abs(there[job] - 1) for job in set(accepted)) + len(set(there) - set(accepted))
    return {
        "sent": len(took),
        "p99": _p99(took),
        "median": statistics.median(took),
        "bare": statistics.median(bare),
        "rate": len(took) / spent,
        "cpu": cpu / len(took) * 1e3,
        "refused": len(refused),
        "refusal": statistics.median(refused) if refused else 0.0,
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
    stuck = [_connected(url, "GET", "/events", end=True) for _ in range(_STUCK)]
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


def _connected(url: str, method: str, path: str, *, end: bool) -> socket.socket:
    """Sends a request, perhaps without the end of its header, and reads nothing."""
    parts = urlsplit(url)
    assert parts.hostname is not None
    connection = socket.create_connection((parts.hostname, parts.port))
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    header = f"{method} {parts.path}{path} HTTP/1.1\r\nHost: {parts.netloc}\r\nContent-Length: 0\r\n"
    connection.sendall((header + ("\r\n" if end else "")).encode())
    return connection


# ---------------------------------------------------------------------- stops


async def _stops(url: str, _server: psutil.Process, load: str) -> dict[str, float]:
    """Requests stops with new connections, beside clients that only hold theirs open."""
    with contextlib.ExitStack() as stack:
        _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(8192, hard), hard))
        for _ in range(_HALF_OPEN if load == "half-open" else 0):
            stack.enter_context(_connected(url, "POST", "/stop", end=False))
        for _ in range(_SLOW if load == "slow" else 0):
            stack.enter_context(_connected(url, "GET", "/events", end=True))
        took = []
        for _ in range(_STOPS):
            begun = time.perf_counter()
            with _connected(url, "POST", "/stop", end=True) as connection:
                answer = connection.recv(4096)
            took.append((time.perf_counter() - begun) * 1e3)
            assert answer.split()[1] in (b"200", b"202"), answer
            await asyncio.sleep(0.1)
    return {"median": statistics.median(took), "worst": max(took)}


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
    "stops": _stops,
    "jobs": _jobs,
    "changes": _changes,
}

if __name__ == "__main__":
    raise SystemExit(main())
