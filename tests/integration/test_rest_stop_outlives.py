"""A stop holds until somebody resets it, whatever becomes of the server."""

from __future__ import annotations

from pathlib import Path

from support.server_process import ServerProcess

from .hard import STARTER, job_of, moves, until


def test_a_halt_survives_a_kill_and_no_job_starts_before_a_reset(tmp_path: Path) -> None:
    with ServerProcess("kitting", "--fake", "--pace", "5", data=tmp_path) as server, server.client() as client:
        assert client.http.post("/stop", json={"reason": "a hand was seen"}).json()["obeyed"]
        client.http.put("/jobs/kit", json=STARTER).raise_for_status()
        until(lambda: (tmp_path / "halted.json").exists())
        server.kill()
    with ServerProcess("--fake", "--pace", "5", data=tmp_path) as server, server.client() as client:
        api = client.http
        stopped = api.get("/stop").json()
        assert (stopped["halted"], stopped["why"]) == (True, "a hand was seen")
        assert job_of(api, "kit")["state"]["text"] == "AllowedToStart"
        assert any(alarm["kind"] == "halted" for alarm in api.get("/alarms", params={"active": True}).json()["items"])
        api.post("/reset").raise_for_status()
        until(lambda: moves(api, "kit"))
        assert not (tmp_path / "halted.json").exists()
