"""The pages in a real browser with software rendering: loading time, frame rate, latencies and memory.

    uv run --all-groups python benchmarks/web.py
    uv run --all-groups python benchmarks/web.py --only frames
    uv run --all-groups python benchmarks/web.py --only memory --minutes 60

Server, physics and browser share the machine. The rate of the control cycle with the browser is compared with its rate
without, in the same run.
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

import httpx2
from playwright.sync_api import Browser, Page
from rest_server import Server, running
from rest_settings import JOB, SCENE
from table import Figure, finish, in_steps
from web_browser import browsing, heap, new_page, ready, transferred
from web_large import large_scene

_TRIES = 5
_MEGABYTE = 1e6
_CALM = 700.0
"""Idle time of the pages between two attempts [ms]."""


def main() -> int:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=25.0, help="for how long frames and cycles are counted")
    parser.add_argument("--objects", type=int, default=2000, help="things in the large scene")
    parser.add_argument("--minutes", type=float, default=15.0, help="for how long memory is watched")
    parser.add_argument("--settled", type=float, default=10.0, help="after so many minutes memory has to be flat")
    parser.add_argument("--only", choices=sorted(_PARTS), help="one part of it")
    options = parser.parse_args()
    parts = [options.only] if options.only else list(_PARTS)
    with browsing() as browser:
        return finish("web", [figure for part in parts for figure in _PARTS[part](browser, options)])


def _pages(server: Server) -> str:
    return server.url.removesuffix("/api/v1") + "/"


# ---------------------------------------------------------------------- opening


def _opening(browser: Browser, _options: argparse.Namespace) -> list[Figure]:
    with _data() as data, running(SCENE, Path(data), "--pace", "real") as server:
        opened = [_open(browser, server) for _ in range(_TRIES)]
    seconds = [one for one, _ in opened]
    pages, api = opened[0][1]["pages"] / _MEGABYTE, opened[0][1]["api"] / _MEGABYTE
    best = min(seconds)
    return [
        in_steps(
            f"usable after opening, best of {_TRIES}",
            best,
            11e6,
            f"median {median(seconds):.2f} s, worst {max(seconds):.2f} s; nothing in the browser's cache",
        ),
        Figure(
            "first load, compressed",
            f"{pages:.2f} MB",
            "<= 1.5 MB",
            pages <= 1.5,
            f"pages; besides {api:.2f} MB of data, the robot's model among it",
        ),
    ]


def _open(browser: Browser, server: Server) -> tuple[float, dict[str, int]]:
    """Returns the time until a page is usable [s], and the data loaded by then and in the next two seconds."""
    page = new_page(browser)
    came = transferred(page)
    start = time.monotonic()
    page.goto(_pages(server))
    ready(page)
    taken = time.monotonic() - start
    page.wait_for_timeout(2000.0)
    page.context.close()
    return taken, came


# ---------------------------------------------------------------------- the 3D view while the robot works


def _frames(browser: Browser, options: argparse.Namespace) -> list[Figure]:
    with _data() as data, running(SCENE, Path(data), "--pace", "real") as server:
        server.order(JOB)
        server.wait_for_start(JOB)
        alone = _cycles(server, options.seconds)
        page = new_page(browser)
        page.goto(_pages(server))
        ready(page)
        page.wait_for_timeout(3000.0)
        page.evaluate(_COUNT)
        beside = _cycles(server, options.seconds)
        frames, moving = _rate(page.evaluate("window.counted"))
        state = server.job(JOB)["state"]["text"]
        page.context.close()
    return [
        in_steps(
            "a frame of the 3D view while the robot works at pace 1",
            1.0 / frames if frames and state == "Running" else math.inf,
            280_000,
            f"{frames:.1f} frames/s, drawn by software, 1280 x 800; job {state}; moving for {100.0 * moving:.0f} % "
            "of the time, else nothing is drawn",
        ),
        Figure(
            "control cycles beside the browser",
            f"{100.0 * beside / alone:.1f} %",
            ">= 95 %",
            beside >= 0.95 * alone,
            f"{beside:.0f} against {alone:.0f} cycles/s without one",
        ),
    ]


_COUNT = """
() => {
  window.counted = [];
  const robot = () => JSON.stringify([window.skiros3d.joints("robot_1"), window.skiros3d.pose("robot_1")]);
  setInterval(() => window.counted.push([performance.now(), window.skiros3d.frames, robot()]), 250);
}
"""


def _rate(counted: list[tuple[float, int, str]]) -> tuple[float, float]:
    """Returns the frame rate while the robot moved [1/s], and the share of time in which it moved."""
    pairs = list(pairwise(counted))
    moved = [(then, now) for then, now in pairs if then[2] != now[2]]
    seconds = sum(now[0] - then[0] for then, now in moved) / 1000.0
    frames = sum(now[1] - then[1] for then, now in moved)
    return frames / max(seconds, 1e-9), len(moved) / max(len(pairs), 1)


def _cycles(server: Server, seconds: float) -> float:
    """Returns the rate of the control cycle by the wall clock [1/s]."""
    with httpx2.Client(base_url=server.url, timeout=30.0) as client:
        first, start = client.get("/state").json()["cycle"], time.monotonic()
        time.sleep(seconds)
        cycles = int(client.get("/state").json()["cycle"]) - int(first)
        return cycles / (time.monotonic() - start)


# ---------------------------------------------------------------------- from a change to pixels


def _change(browser: Browser, _options: argparse.Namespace) -> list[Figure]:
    with _data() as data, running(SCENE, Path(data), "--pace", "real") as server:
        page = new_page(browser)
        page.goto(f"{_pages(server)}#/world")
        ready(page)
        page.wait_for_function("() => window.skiros3d.pose('rack_1') !== null")
        page.get_by_role("treeitem").filter(has_text="rack_1").first.wait_for()
        page.wait_for_timeout(_CALM)
        moved = [_change_to_pixels(page, server, *_move(0.01 * number)) for number in range(_TRIES)]
        named = [_change_to_pixels(page, server, *_rename(f"rack no {number}")) for number in range(_TRIES)]
        page.context.close()
    return [
        in_steps(
            f"{name} by somebody else, to pixels, best of {_TRIES}",
            min(taken) / 1e3,
            1.7e6,
            f"median {median(taken):.0f} ms, worst {max(taken):.0f} ms; from before the request",
        )
        for name, taken in (("a thing moved in 3D", moved), ("a thing renamed in the tree", named))
    ]


def _move(shift: float) -> tuple[dict[str, Any], str]:
    """Returns a change of a pose, and a test in the page whether it is drawn."""
    x = 1.5 + shift
    pose = {"position": [x, 0.5, 0.0], "orientation": [0.0, 0.0, 0.0, 1.0], "frame": None}
    return {"properties": {"sk:pose": pose}}, f"Math.abs(window.skiros3d.pose('rack_1')[0] - {x}) < 1e-6 && drawn()"


def _rename(label: str) -> tuple[dict[str, Any], str]:
    return {"label": label}, f"document.querySelector('[role=tree]').textContent.includes('{label}')"


_WATCH = """
(done) => {
  const there = new Function("drawn", `return (${done})`);
  let frames = null;  // when it was there: what is drawn from then on shows it
  const drawn = () => window.skiros3d.frames > (frames ??= window.skiros3d.frames);
  window.seen = new Promise((resolve) => {
    const look = () => (there(drawn) ? setTimeout(() => resolve(Date.now())) : requestAnimationFrame(look));
    look();
  });
}
"""


def _change_to_pixels(page: Page, server: Server, change: dict[str, Any], done: str) -> float:
    """Returns the time from the request to the painted result [ms]; both clocks are the machine's."""
    page.evaluate(_WATCH, done)
    start = time.time() * 1000.0
    url = f"{server.url}/elements/rack_1"
    httpx2.patch(url, json=change, headers={"If-Match": "*"}, timeout=30.0).raise_for_status()
    seen: float = page.evaluate("window.seen")
    page.wait_for_timeout(_CALM)
    return seen - start


# ---------------------------------------------------------------------- many things


def _large(browser: Browser, options: argparse.Namespace) -> list[Figure]:
    with _data() as data, running(SCENE, Path(data), "--fake", "--pace", "real") as server:
        costs = large_scene(browser, server, _pages(server), options.objects)
    return [
        in_steps(
            f"{name}, {options.objects} things, best of {len(taken)}",
            min(taken) / 1e3,
            1.1e6,
            f"median {median(taken):.0f} ms, worst {max(taken):.0f} ms",
        )
        for name, taken in costs.items()
    ]


# ---------------------------------------------------------------------- memory


def _memory(browser: Browser, options: argparse.Namespace) -> list[Figure]:
    """Runs jobs on the fake robot, at several times real time, to cause more events.

    The operator looks at another tab for each of them, and at the first one whenever memory is read.
    """
    held: list[tuple[float, float]] = []
    with _data() as data, running(SCENE, Path(data), "--fake", "--pace", "5") as server:
        page = new_page(browser)
        page.goto(_pages(server))
        ready(page)
        tabs = [page.get_by_role("tab", name=name, exact=True) for name in ("Goal", "Task", "Modules", "World")]
        begun, jobs = time.monotonic(), 0
        while (minutes := (time.monotonic() - begun) / 60.0) < options.minutes:
            tabs[jobs % len(tabs)].click()
            jobs += 1
            _job(server, f"job-{jobs}")
            tabs[0].click()
            page.wait_for_timeout(_CALM)
            held.append((minutes, heap(page)))
            print(f"{minutes:5.1f} min  {held[-1][1]:5.1f} MiB", file=sys.stderr, flush=True)
        page.context.close()
    settled = [used for at, used in held if at >= options.settled]
    first, last = median(settled[:_TRIES]), median(settled[-_TRIES:])
    return [
        Figure(
            f"memory of the page after {options.minutes:g} minutes of jobs",
            f"{last / first:.3f} x",
            "<= 1.1 x",
            last <= 1.1 * first,
            f"{last:.1f} MiB against {first:.1f} MiB after {options.settled:g} minutes (medians of {_TRIES} readings);"
            f" at most {max(settled):.1f} MiB; {jobs} jobs",
        )
    ]


def _job(server: Server, job: str) -> None:
    """Lets the robot fill the kit, then moves the parts back."""
    server.order(job)
    server.wait_for_end(job)
    for part, place in (("starter_1", "pallet_a"), ("alternator_1", "pallet_a"), ("compressor_1", "pallet_b")):
        body = {"placement": {"relation": "sk:in", "place": place}}
        url = f"{server.url}/elements/{part}"
        httpx2.patch(url, json=body, headers={"If-Match": "*"}, timeout=30.0).raise_for_status()


def _data() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="skiros-bench-")


_PARTS: dict[str, Callable[[Browser, argparse.Namespace], list[Figure]]] = {
    "opening": _opening,
    "frames": _frames,
    "change": _change,
    "large": _large,
    "memory": _memory,
}

if __name__ == "__main__":
    sys.exit(main())
