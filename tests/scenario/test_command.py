"""The command as a stranger types it: exit statuses, one JSON object, Ctrl-C."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time

import psutil
import pytest

COMMAND = [sys.executable, "-m", "skiros_py.cli", "run"]


@pytest.mark.physics
def test_ctrl_c_stops_the_robot_and_leaves_no_process_behind():
    process = subprocess.Popen(
        [*COMMAND, "kitting", "--pace", "real"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("plan"):
            break
    time.sleep(2.0)
    children = psutil.Process(process.pid).children(recursive=True)

    process.send_signal(signal.SIGINT)
    rest, _ = process.communicate(timeout=60)

    assert process.returncode == 130
    assert children
    assert psutil.wait_procs(children, timeout=10)[1] == []
    assert "stopped" in rest
    assert "Traceback" not in rest


@pytest.mark.physics
def test_a_killed_run_takes_its_worker_processes_with_it():
    process = subprocess.Popen([*COMMAND, "kitting", "--pace", "real"], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("plan"):
            break
    children = psutil.Process(process.pid).children(recursive=True)

    process.kill()
    process.communicate(timeout=30)

    assert children
    assert psutil.wait_procs(children, timeout=10)[1] == []


def test_a_goal_without_a_plan_prints_the_reason_and_exits_with_3():
    done = subprocess.run(
        [*COMMAND, "kitting", "--fake", "--json", "--goal", "ObjectAtLocation(starter_1, pallet_b)"],
        capture_output=True,
        text=True,
        check=False,
    )

    report = json.loads(done.stdout)
    assert done.returncode == 3
    assert "pallet_b" in report["no_plan"][0]
