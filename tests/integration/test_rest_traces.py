"""What the trace of a job says of each step."""

from __future__ import annotations

import time
from pathlib import Path

import httpx2
from support.serving import serving

PATIENCE = 60.0


def test_each_step_in_a_trace_has_its_inputs_conditions_and_world_changes(tmp_path: Path) -> None:
    with (
        serving("kitting", tmp_path) as server,
        httpx2.Client(base_url=f"{server.url}/api/v1", timeout=PATIENCE) as http,
    ):
        http.put("/jobs/kit", json={"goal": "InKit(Starter, kit_1)"}, headers={"Prefer": "wait=30"}).raise_for_status()
        deadline = time.monotonic() + PATIENCE
        while len(entries := http.get("/jobs/kit/trace").json()["items"]) < 11 and time.monotonic() < deadline:
            time.sleep(0.01)
        steps = [entry for entry in entries if entry["what"] == "ended"]
        ways = {
            (step["skill"]): [
                way["label"] for way in http.get(f"/modules/{step['agent']}/{step['skill']}").json()["implementations"]
            ]
            for step in steps
        }
        changes = [[http.get(f"/world/changes/{n}").json() for n in step["data"]["changes"]] for step in steps]

    assert [step["skill"] for step in steps] == ["drive", "pick", "drive", "place"]
    for step in steps:
        said = {key: value for key, value in step["data"]["inputs"].items() if value is not None}
        assert said == step["arguments"]
        assert step["data"]["implementation"] in ways[step["skill"]]
        assert {row["kind"] for row in step["data"]["conditions"]} >= {"pre", "post"}
        assert all(row["holds"] and row["why"] for row in step["data"]["conditions"])
    assert [{change["author"] for change in of_one} for of_one in changes] == [
        {"drive"},
        {"pick"},
        {"drive"},
        {"place"},
    ]
