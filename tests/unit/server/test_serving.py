"""What the server loads before it listens."""

from __future__ import annotations

import sys

from support import warm_python

FIRST_STREAM = """
import asyncio, contextlib, sys
from fastapi import FastAPI
from skiros_py.server.serving import _warm_up
from skiros_py.server.streams import EventStream

async def frames():
    yield b"data: 1"

async def send(_message):
    pass

asyncio.run(_warm_up(FastAPI()))
before = set(sys.modules)
stream = EventStream(frames(), contextlib.nullcontext())
asyncio.run(stream({"type": "http", "path": "/events"}, asyncio.Event().wait, send))
print(*sorted(set(sys.modules) - before))
"""


def test_the_first_stream_imports_nothing_in_the_event_loop() -> None:
    ended = warm_python.run([sys.executable, "-c", FIRST_STREAM])

    assert (ended.stdout.strip(), ended.stderr) == ("", "")
