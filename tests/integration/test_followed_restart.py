"""Who follows a job follows it on when the server is killed and another one takes its place."""

from __future__ import annotations

import asyncio
import json
import subprocess
import threading
from pathlib import Path

from support import warm_python
from support.server_process import ServerProcess

from skiros_py.api.events import EventInfo, ResetInfo
from skiros_py.api.jobs import JobOrder
from skiros_py.client import AsyncClient
from skiros_py.client.streams import stream_job_events

PATIENCE = 60.0


class Follower(threading.Thread):
    """Follows a job with an asynchronous client until it is over."""

    def __init__(self, data: Path) -> None:
        super().__init__(name="follower", daemon=True)
        self._data = data
        self.seen: list[EventInfo | ResetInfo] = []
        self.sees = threading.Event()

    def run(self) -> None:
        asyncio.run(self._follow())

    async def _follow(self) -> None:
        async with AsyncClient.of_data(self._data) as client:
            async for event in client.follow(stream_job_events("kept")):
                self.seen.append(event)
                self.sees.set()
                if (await client.jobs.get("kept")).outcome is not None:
                    return


def watching(data: Path) -> subprocess.Popen[str]:
    command = [*warm_python.SKIROS, "job", "watch", "kept", "--data", str(data), "--json"]
    return warm_python.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_a_job_is_followed_across_a_restart_at_another_address(tmp_path: Path) -> None:
    with ServerProcess("kitting", "--fake", data=tmp_path) as first:
        with first.client() as client:
            client.jobs.put("kept", JobOrder(goal="InKit(Starter, kit_1)"), start=False)
        follower = Follower(tmp_path)
        follower.start()
        watch = watching(tmp_path)
        assert watch.stderr is not None
        assert "NotAllowedToStart" in watch.stderr.readline()
        assert follower.sees.wait(PATIENCE)
        first.kill()
    with ServerProcess("--fake", "--pace", "max", data=tmp_path) as second, second.client() as client:
        client.jobs.start("kept")
        out, err = watch.communicate(timeout=PATIENCE)
        follower.join(PATIENCE)

    assert (watch.returncode, json.loads(out)["outcome"]) == (0, "succeeded"), err
    numbers = [event.id for event in follower.seen]
    assert len(numbers) == len(set(numbers))
    assert [event.code for event in follower.seen if isinstance(event, ResetInfo)] == ["restarted"]
    assert not follower.is_alive()
