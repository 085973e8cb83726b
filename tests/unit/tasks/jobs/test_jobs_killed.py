"""A program that takes orders is killed at a random moment: what it acknowledged is there, once, with its receipt."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest

from skiros_py.tasks.jobs.job import JobOrder
from skiros_py.tasks.jobs.store import JobStore, Receipt

_TAKING = """
import sys, threading
from pathlib import Path
from skiros_py.tasks.jobs.job import JobOrder
from skiros_py.tasks.jobs.manager import JobManager
from skiros_py.tasks.jobs.store import JobStore, Receipt
from skiros_py.testing import Bench, tiny_world
with Bench(tiny_world()) as bench:
    store = JobStore(Path(sys.argv[1]))
    jobs = JobManager(bench.tasks, bench.runtime, store, lambda texts: bench.goal(*texts))
    def take(thread):
        for n in range(100_000):
            id_ = f"{thread}-{n}"
            order = JobOrder(id=id_, goal=("In(ball_1, slot_1)",))
            job = jobs.submit(order, start=False, receipt=Receipt("mes", id_, "digest"))
            sys.stdout.write(f"{id_} {job.number}\\n"); sys.stdout.flush()
    for thread in range(3):
        threading.Thread(target=take, args=(thread,), daemon=True).start()
    threading.Event().wait()
"""


@pytest.mark.parametrize("seed", range(3))
def test_acknowledged_orders_and_their_receipts_survive_a_kill(tmp_path: Path, seed: int) -> None:
    acknowledged = _take_and_kill(tmp_path / "jobs.db", lasting=random.Random(seed).uniform(0.05, 0.5))
    assert acknowledged
    with closing(JobStore(tmp_path / "jobs.db")) as store:
        kept = {job.id: job.number for job in store.open()}
        assert acknowledged.items() <= kept.items()
        assert sorted(kept.values()) == list(range(1, len(kept) + 1))
        assert [each.job.id for each in store.announcements(0, len(kept) + 9)] == list(kept)
        for id_ in kept:  # one that was kept but not acknowledged is known as well, or it would be done twice
            known = store.known(Receipt("mes", id_, "digest"))
            assert known is not None
            assert known.order == JobOrder(id=id_, goal=("In(ball_1, slot_1)",))


def _take_and_kill(file: Path, lasting: float) -> dict[str, int]:
    """Returns the numbers of the jobs that were acknowledged, by their ids."""
    with subprocess.Popen([sys.executable, "-c", _TAKING, str(file)], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        first = process.stdout.readline()
        time.sleep(lasting)
        os.kill(process.pid, signal.SIGKILL)
        lines = [first, *process.stdout]
    whole = (line.split() for line in lines if line.endswith("\n") and len(line.split()) == 2)
    return {id_: int(number) for id_, number in whole}
