"""Two robots of one scene, each with a server of its own, and one client that drives both."""

from __future__ import annotations

import asyncio
from pathlib import Path

from support.server_process import ServerProcess

from skiros_py.api.jobs import Job, JobOrder
from skiros_py.client import AsyncClient

GOALS = {"robot_1": "InKit(Starter, kit_1)", "robot_2": "InKit(Starter, kit_2)"}


async def drive(robot: str, data: Path) -> tuple[Job, set[str]]:
    """Orders a robot's own goal from its own server, and returns what came of it, and which robots were used."""
    async with AsyncClient.of_data(data) as client:
        ordered = await client.jobs.order(JobOrder(goal=GOALS[robot]))
        job = await client.jobs.wait(ordered.id, timeout=120.0)
        response = await client.jobs.response(job.id)
        return job, {step.arguments["Robot"] for step in response.job_response_data}


async def drive_both(folder: Path) -> list[tuple[Job, set[str]]]:
    return await asyncio.gather(*(drive(robot, folder / robot) for robot in GOALS))


def test_one_client_controls_two_servers_with_one_robot_each(tmp_path: Path) -> None:
    start = ("kitting_two", "--fake", "--pace", "40", "--robot")
    with (
        ServerProcess(*start, "robot_1", data=tmp_path / "robot_1"),
        ServerProcess(*start, "robot_2", data=tmp_path / "robot_2"),
    ):
        (first, robots_1), (second, robots_2) = asyncio.run(drive_both(tmp_path))
    assert (first.outcome, second.outcome) == ("succeeded", "succeeded")
    assert (robots_1, robots_2) == ({"robot_1"}, {"robot_2"})
