"""A resident program runs Python modules at once, ends runs that are no longer wanted, and may be killed."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import psutil
import pytest

from skiros_py.planning.planners.fast_downward import Resident, ResidentRun, Run
from skiros_py.programs import Ended, Limits, run_program

SAYS = """
import os, sys
import said
print("argument", sys.argv[1], "loaded", said.BY == os.getppid(), flush=True)
open("input", "w").write("read")
sys.exit(int(sys.argv[2]))
"""
LOADED = "import os\nBY = os.getpid()\n"
DIES = """
import os, signal
fork = os.fork
def fork_and_die():
    pid = fork()
    if pid != 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return pid
os.fork = fork_and_die
"""
REPORTS_LATE = """
import os, time
setsid = os.setsid
def setsid_later():
    time.sleep(1.0)
    setsid()
os.setsid = setsid_later
"""
LASTS = """
import os, pathlib, time
pathlib.Path("written").write_text(str(os.getpid()))
pathlib.Path("written").rename("pid")
time.sleep(3600)
"""
FREEZES = """
import os, signal
setsid = os.setsid
def setsid_and_freeze():
    setsid()
    open("frozen", "w").write(str(os.getpid()))
    os.kill(os.getpid(), signal.SIGSTOP)
os.setsid = setsid_and_freeze
"""
LIMITS = Limits(time=20.0)


@pytest.fixture
def modules(tmp_path: Path) -> Path:
    folder = tmp_path / "modules"
    folder.mkdir()
    (folder / "said.py").write_text(LOADED)
    (folder / "says.py").write_text(SAYS.replace("sys.exit(int(sys.argv[2]))", "if sys.argv[2] != '0': sys.exit(7)"))
    (folder / "waits.py").write_text("import time\ntime.sleep(3600)\n")
    (folder / "dies.py").write_text(DIES)
    (folder / "reports_late.py").write_text(REPORTS_LATE)
    (folder / "lasts.py").write_text(LASTS)
    (folder / "freezes.py").write_text(FREEZES.replace('"frozen"', repr(str(tmp_path / "frozen"))))
    return folder


@pytest.fixture
def resident(modules: Path) -> Iterator[Resident]:
    with closing(Resident("the program", modules, ["said"])) as resident:
        yield resident


def ran(resident: Resident, folder: Path, run: Run, stopped: Callable[[], bool] = lambda: False) -> Ended:
    return run_program("it", lambda environment: resident.start(run, folder, LIMITS, environment), LIMITS, stopped)


def of(module: str, *arguments: str) -> Run:
    return Run(module, arguments, ("/bin/cat",), "input")


def test_a_module_runs_with_what_is_loaded_already_and_then_the_program_that_reads_what_it_wrote(
    resident: Resident, tmp_path: Path
) -> None:
    ended = ran(resident, tmp_path, of("says", "one", "0"))

    assert (ended.code, ended.output) == (0, "argument one loaded True\nread")


def test_an_exit_code_of_the_module_is_returned_and_the_program_is_not_run(resident: Resident, tmp_path: Path) -> None:
    ended = ran(resident, tmp_path, of("says", "one", "1"))

    assert (ended.code, ended.output) == (7, "argument one loaded True\n")


def test_an_exception_in_the_module_is_printed(resident: Resident, tmp_path: Path) -> None:
    ended = ran(resident, tmp_path, of("nothing_of_that_name"))

    assert ended.code == 1
    assert "No module named nothing_of_that_name" in ended.output


def waiting(resident: Resident, folder: Path) -> tuple[ResidentRun, psutil.Process]:
    before = {p.pid for p in psutil.Process().children(recursive=True)}
    run = resident.start(of("waits"), folder, LIMITS, os.environ)
    while True:
        for process in psutil.Process().children(recursive=True):
            if process.pid not in before and process.ppid() != os.getpid():
                return run, process
        time.sleep(0.01)


def test_a_run_is_killed_when_its_caller_stops_waiting(resident: Resident, tmp_path: Path) -> None:
    run, process = waiting(resident, tmp_path)
    assert not run.has_ended()
    run.kill()

    process.wait(5.0)


def test_closing_ends_running_processes(resident: Resident, tmp_path: Path) -> None:
    _, process = waiting(resident, tmp_path)
    resident.close()

    process.wait(5.0)


def test_killing_the_resident_program_ends_its_run_and_the_next_run_starts_a_new_one(
    resident: Resident, tmp_path: Path
) -> None:
    run, process = waiting(resident, tmp_path)
    parent = process.parent()
    assert parent is not None
    parent.kill()
    while not run.has_ended():
        time.sleep(0.01)

    assert run.kill() == -9
    process.wait(5.0)
    assert ran(resident, tmp_path, of("says", "two", "0")).code == 0


@pytest.mark.parametrize("awaited", [False, True], ids=["cancelled at once", "awaited"])
def test_a_suspended_resident_program_is_killed_and_the_next_run_starts_another(
    resident: Resident, tmp_path: Path, awaited: bool
) -> None:
    other, process = waiting(resident, tmp_path)
    parent = process.parent()
    assert parent is not None
    parent.send_signal(signal.SIGSTOP)
    run = resident.start(of("says", "one", "0"), tmp_path, LIMITS, os.environ)
    while awaited and not run.has_ended():  # the signal takes effect a little later
        time.sleep(0.01)

    assert run.kill() == -9
    parent.wait(5.0)
    assert other.kill() == -9
    assert ran(resident, tmp_path, of("says", "two", "0")).code == 0


def test_a_run_ends_even_if_the_resident_program_is_killed_right_after_starting_it(
    modules: Path, tmp_path: Path
) -> None:
    with closing(Resident("the program", modules, ["said", "dies"])) as resident:
        run = resident.start(of("lasts"), tmp_path, LIMITS, os.environ)
        while not (tmp_path / "pid").exists():
            time.sleep(0.01)
        process = psutil.Process(int((tmp_path / "pid").read_text()))

        assert run.has_ended()
        assert run.kill() == -9
        process.wait(5.0)


def test_a_run_that_reports_only_after_the_resident_program_was_killed_is_killed_too(
    modules: Path, tmp_path: Path
) -> None:
    with closing(Resident("the program", modules, ["said", "dies", "reports_late"])) as resident:
        run = resident.start(of("lasts"), tmp_path, LIMITS, os.environ)

        assert run.kill() == -9
        time.sleep(1.0)  # it would have begun by then
        assert not (tmp_path / "pid").exists()


def test_a_run_suspended_before_it_could_report_is_killed_and_the_resident_program_goes_on(
    modules: Path, tmp_path: Path
) -> None:
    with closing(Resident("the program", modules, ["said", "freezes"])) as resident:
        run = resident.start(of("lasts"), tmp_path, LIMITS, os.environ)
        while not (frozen := tmp_path / "frozen").exists() or not frozen.read_text():
            time.sleep(0.01)
        process = psutil.Process(int(frozen.read_text()))
        program = process.parent()

        assert run.kill() == -9
        process.wait(5.0)
        assert program is not None
        assert program.is_running()
