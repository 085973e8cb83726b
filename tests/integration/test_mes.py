"""A factory system orders three kits over a bad network, and the server is killed meanwhile: each kit is done once."""

from __future__ import annotations

import random
import re
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path

from support.server_process import ServerProcess

from skiros_py.api.jobs import Job, JobOrder
from skiros_py.api.server import KeyOrder
from skiros_py.client import Client, ProblemError
from skiros_py.client.topics import Station
from skiros_py.config import find_scene

from .chaos import BadNetwork

KITS = (1, 2, 3)
PARTS = ("starter", "alternator")
PATIENCE = 120.0


def three_kits(folder: Path) -> Path:
    """The kitting scene with two more kits on tables of their own, and the parts for them."""
    text = find_scene("kitting").read_text(encoding="utf-8")
    kit = re.search(r"^scene:kit_table a .*?(?=^# -+ parts)", text, re.DOTALL | re.MULTILINE)
    assert kit is not None
    more = [another_kit(kit[0], number, y) for number, y in ((2, "2"), (3, "-2"))]
    parts = [
        f'scene:{part}_{number} a kitting:{part.title()} ; rdfs:label "{part}" ; sk:in scene:pallet_a .'
        for part in PARTS
        for number in (2, 3)
    ]
    file = folder / "three_kits.ttl"
    file.write_text("\n".join((text, *more, *parts, "")), encoding="utf-8")
    return file


def another_kit(text: str, number: int, y: str) -> str:
    renamed = text.replace("kit_1", f"kit_{number}").replace("kit_table", f"kit_table_{number}")
    return renamed.replace('"-1.6 0 ', f'"-1.6 {y} ').replace('"-1.55 0 ', f'"-1.55 {y} ')


def orders() -> list[JobOrder]:
    return [
        JobOrder(id=f"kit-{kit}", goal=tuple(f"InKit({part.title()}, kit_{kit})" for part in PARTS)) for kit in KITS
    ]


def order_badly(url: str, key: str, rng: random.Random) -> None:
    """Sends each order four times, in any order and at once; every answer must be about the same job."""
    messages = orders() * 4
    rng.shuffle(messages)

    def send(order: JobOrder) -> Job:
        assert order.id is not None
        with Client(url, key, timeout=10.0, tries=12) as client:
            return client.jobs.put(order.id, order) if rng.random() < 0.5 else client.jobs.order(order)

    with ThreadPoolExecutor(6) as pool:
        answers = list(pool.map(send, messages))
    numbers = {(answer.id, answer.number) for answer in answers}
    assert sorted(id_ for id_, _ in numbers) == [order.id for order in orders()]


@contextmanager
def somebody_at_the_cell(server: ServerProcess) -> Iterator[None]:
    """While the block lasts, resets what the watchdog halts on a slow machine, and lets go on what stood then."""
    leaves = threading.Event()

    def attend() -> None:
        with server.client() as operator:
            while not leaves.wait(0.5):
                with suppress(ProblemError):  # it has gone on by itself, or is halted once more
                    reset_and_go_on(operator)

    thread = threading.Thread(target=attend)
    thread.start()
    try:
        yield
    finally:
        leaves.set()
        thread.join()


def answer(client: Client, job: str, choice: str) -> None:
    """Answers what a job waits for, again while everything is halted."""
    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            client.jobs.answer(job, choice)
        except ProblemError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.5)
        else:
            return


def reset_and_go_on(operator: Client) -> None:
    if operator.send(Station.get_stop()).halted:
        operator.send(Station.reset())
    for job in operator.jobs.list(states=("Interrupted",)).items:
        if "everything was halted" in job.detail:
            operator.jobs.answer(job.id, "retry")


def moving(client: Client) -> str:
    """Waits until something moves for a job, and returns its id."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        for job in client.jobs.list(states=("Running",)).items:
            if any(step.ended is None for step in client.jobs.response(job.id).job_response_data):
                return job.id
        time.sleep(0.02)
    raise AssertionError("nothing moves")


def port_of(server: ServerProcess) -> int:
    return int(server.url.rpartition(":")[2])


def times_placed(client: Client, part: str, kit: int) -> int:
    """How often a part was put into a kit, after the world's own history."""
    changes = client.elements.history(part, newest_first=False, limit=200).items
    placed = (edit for change in changes for edit in change.edits if edit["edit"] == "placement")
    return sum(
        edit["element"] == part and str((edit["new"] or {}).get("place", "")).startswith(f"kit_{kit}_")
        for edit in placed
    )


def test_each_of_three_kits_is_done_exactly_once(tmp_path: Path) -> None:
    rng = random.Random(5)
    data, start = tmp_path / "data", ("--fake", "--pace", "40", "--auth", "keys")
    with BadNetwork() as network:
        with ServerProcess(str(three_kits(tmp_path)), *start, data=data) as server:
            with server.client() as admin:
                key = admin.keys.create(KeyOrder(name="line 1", role="mes")).secret
            network.target, network.lose = port_of(server), 3
            order_badly(network.url, key, rng)
            with somebody_at_the_cell(server), server.client() as admin:
                cut_off = moving(admin)
            network.target = None
            server.kill()
        with ServerProcess(*start, data=data) as server:
            network.target = port_of(server)
            order_badly(network.url, key, rng)  # it does not know what has arrived
            with Client(network.url, key, timeout=10.0, tries=12) as mes:
                held = mes.jobs.get(cut_off)
                assert (held.state.text, held.state.substates) == ("Interrupted", ("Held",))
                assert "look, then answer" in held.detail
                with somebody_at_the_cell(server):
                    answer(mes, cut_off, "retry")
                    done = [mes.jobs.wait(f"kit-{kit}", timeout=PATIENCE) for kit in KITS]
            with server.client() as admin:
                kits = [
                    sorted(part for part in PARTS for number in KITS if times_placed(admin, f"{part}_{number}", kit))
                    for kit in KITS
                ]
                placed = [
                    sum(times_placed(admin, f"{part}_{number}", kit) for kit in KITS)
                    for part in PARTS
                    for number in KITS
                ]
                jobs = admin.jobs.list().items
    assert network.lost > 0
    assert [(job.outcome, job.reasons) for job in done] == [("succeeded", ())] * 3
    assert [job.id for job in sorted(jobs, key=lambda job: job.id)] == ["kit-1", "kit-2", "kit-3"]
    assert kits == [sorted(PARTS)] * 3
    assert placed == [1] * 6
