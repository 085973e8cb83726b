"""Planners that do everything wrong: little scripts, really run. None harms us, and nothing of them stays behind."""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from support.planning import tiny_pddl

from skiros_py.errors import PlanningError, UsageError
from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.planners.planner import Planner, Planners, Unsolvable
from skiros_py.planning.planners.program_planner import EVERYTHING, CommandPlanner
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.process import ThreadHost
from skiros_py.planning.requests import PlanRequest
from skiros_py.planning.service import Planned
from skiros_py.programs import Limits
from skiros_py.testing import SKILLS, Bench, tiny_world
from skiros_py.testing.tiny import IN_CONTAINER

GOAL = "In(ball_1, slot_1)"
LIMITS = Limits(time=30.0)
PLAN = """\
(drive base_1 robot_1 box_a unknown_location)
(pick arm_1 gripper_1 robot_1 box_a ball_1)
(place arm_1 gripper_1 robot_1 ball_1 slot_1)
"""
STUBBORN = "import signal, time\nfor n in (1, 2, 15): signal.signal(n, signal.SIG_IGN)\n"
LEAVES_GROUP = (
    "import os, time\nif os.fork() == 0:\n    os.setsid()\n    if os.fork() == 0: time.sleep(3600)\n    os._exit(0)\n"
)


_BEFORE: set[int] = set()
"""Our children when a test began: other tests may have left workers behind for the next."""


@pytest.fixture(autouse=True)
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A place of its own for temporary files: when the test is over, no file is there and no process runs."""
    place = tmp_path / "temporary"
    place.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(place))
    _BEFORE.clear()
    _BEFORE.update(child.pid for child in psutil.Process().children(recursive=True))
    yield place
    assert list(place.iterdir()) == []
    deadline = time.monotonic() + 5.0
    while strays(tmp_path) and time.monotonic() < deadline:  # killed, and not yet gone
        time.sleep(0.01)
    assert strays(tmp_path) == []


def strays(folder: Path) -> list[str]:
    """Returns what runs that was started from a folder, and our children that were not there before the test."""
    found = [words for pid in psutil.pids() if str(folder / "planner") in (words := words_of(pid))]
    new = (child.pid for child in psutil.Process().children(recursive=True) if child.pid not in _BEFORE)
    return found + [words for pid in new if (words := words_of(pid))]


def words_of(pid: int) -> str:
    try:
        process = psutil.Process(pid)
        return "" if process.status() == psutil.STATUS_ZOMBIE else " ".join(process.cmdline())
    except psutil.Error:
        return ""


def script(folder: Path, text: str, name: str = "planner", limits: Limits = LIMITS) -> CommandPlanner:
    """Returns a planner that is a Python script; ``write(text)`` writes its plan file."""
    path = folder / f"{name}.py"
    head = "import sys\ndef write(text):\n    with open(sys.argv[3], 'w') as file: file.write(text)\n"
    path.write_text(f"{head}PLAN = {PLAN!r}\n{text}\n")
    command = f"{sys.executable} -S {path} {{domain}} {{problem}} {{plan}}"
    return CommandPlanner(name, command, supports=EVERYTHING, limits=limits)


def planned(*planners: Planner, goal: str = GOAL) -> Planned:
    by_name = {planner.name: planner for planner in planners}
    choice = Planners(by_name, by_name.__getitem__)
    with Bench(tiny_world(), planner=choice) as bench:
        return bench.plan(goal)


def fault(*planners: Planner, goal: str = GOAL) -> str:
    with pytest.raises(PlanningError) as caught:
        planned(*planners, goal=goal)
    return str(caught.value)


def test_a_correct_script_works_as_a_planner(tmp_path: Path) -> None:
    found = planned(script(tmp_path, "write(PLAN)"))

    assert isinstance(found.outcome, Plan)
    assert [step.skill for step in found.outcome.steps] == ["drive", "pick", "place"]
    assert (found.planner, found.notes) == ("planner", ())


# ------------------------------------------------------------------ faults with a name


def test_a_missing_planner_is_reported_with_its_program() -> None:
    planner = CommandPlanner("popf", "popf3-clp {domain} {problem}")

    assert fault(planner) == "planner 'popf' cannot be started: 'popf3-clp': No such file or directory"


def test_a_planner_that_is_not_executable_is_named(tmp_path: Path) -> None:
    (tmp_path / "tool").write_text("#!/bin/sh\n")

    words = fault(CommandPlanner("tool", f"{tmp_path / 'tool'} {{domain}} {{problem}}"))

    assert words.endswith("Permission denied")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("import os\nos.kill(os.getpid(), 9)", "planner 'planner' was killed by SIGKILL and said nothing"),
        ("print('out of cheese'); sys.exit(3)", "planner 'planner' ended with code 3:\nout of cheese"),
        ("import os\nwrite(PLAN); os.abort()", "planner 'planner' was killed by SIGABRT and said nothing"),
        ("write('Segmentation fault (core dumped)')", "line 1 is no step: 'Segmentation fault (core dumped)'"),
        ("write(PLAN[:-20])", "line 3 is no step: '(place arm_1"),
        ("write('(fly robot_1)')", "'fly', which is not in the task"),
        ("write('(drive base_1)')", "(drive base_1), but drive takes 4 objects"),
        ("write(PLAN * 5000)", "15000 steps: no plan is that long"),
        ("write('\\0' * 100)", "line 1 is no step"),
        ("write('(a' + ' b' * 9_000_000)", "a plan of more than 16 MiB"),
        ("import os\nos.mkfifo(sys.argv[3])", "left 'plan', which is a pipe or device and no plan file"),
        ("import os\nos.mkdir(sys.argv[3])", "planner 'planner' left 'plan', which is a folder and no plan file"),
        ("import os\nos.symlink('/dev/zero', sys.argv[3])", "left 'plan', which is a link and no plan file"),
        ("write('')", "the plan of planner is empty: In(ball_1, slot_1)"),
        ("write('; nothing')", "the plan of planner is empty: In(ball_1, slot_1)"),
        ("write(PLAN[:90])", "the plan of planner breaks at the end: In(ball_1, slot_1)"),
        ("write(PLAN.partition('\\n')[2])", "the plan of planner breaks at step 1 (pick"),
        ("pass", "it left no plan, and ended with code 0 and said nothing"),
        ("print('\\x1b[2J(((')", "it left no plan, and ended with code 0:\n\ufffd[2J((("),
    ],
)
def test_an_invalid_plan_is_a_fault_of_the_planner(tmp_path: Path, text: str, words: str) -> None:
    assert words in fault(script(tmp_path, text))


def test_a_proven_impossibility_does_not_depend_on_the_answer_of_the_planner(tmp_path: Path) -> None:
    outcome = planned(script(tmp_path, "write('')"), goal="In(ball_1, slot_1) and In(ball_1, slot_2)").outcome

    assert isinstance(outcome, NoPlan)
    assert "ball_1" in outcome.reasons[0]


def test_a_planner_out_of_memory_is_reported(tmp_path: Path) -> None:
    planner = script(tmp_path, "x = bytearray(1 << 30)", limits=Limits(memory=256 << 20))

    assert fault(planner) == (
        "planner 'planner' ran out of memory (it may take 0.25 GiB) and ended with code 1:\nMemoryError"
    )


def test_a_crashing_python_planner_is_reported_by_its_message_without_a_traceback(tmp_path: Path) -> None:
    planner = script(tmp_path, "print('hello', flush=True)\nraise ValueError('out of cheese')")

    assert fault(planner) == "planner 'planner' ended with code 1:\nhello\nValueError: out of cheese"


def test_a_planner_over_its_time_limit_is_stopped(tmp_path: Path) -> None:
    planner = script(tmp_path, "import time\nwrite(PLAN)\ntime.sleep(3600)", limits=Limits(time=0.5))

    assert fault(planner) == "planner 'planner' found no answer in 0.5 s"


def test_a_planner_with_endless_output_is_stopped(tmp_path: Path) -> None:
    planner = script(tmp_path, "while True: print('x' * 10_000)", limits=Limits(output=1 << 20))

    assert fault(planner).startswith("planner 'planner' printed more than 1 MiB: 'xxx")


def test_a_planner_that_fills_the_disk_is_stopped(tmp_path: Path) -> None:
    text = "while True: open('big', 'ab').write(b'x' * 100_000)"

    words = fault(script(tmp_path, text, limits=Limits(file=1 << 20)))

    assert "File too large" in words or "SIGXFSZ" in words


def test_much_output_of_a_working_planner_is_accepted(tmp_path: Path) -> None:
    planner = script(tmp_path, "print('x' * 3_000_000, flush=True)\nwrite(PLAN)")

    assert isinstance(planned(planner).outcome, Plan)


# ------------------------------------------------------------------ answers that are not believed


def test_a_plan_for_another_problem_does_not_survive_the_replay(tmp_path: Path) -> None:
    words = fault(script(tmp_path, "write(PLAN)"), goal="In(ball_1, slot_2)")

    assert words.startswith("the plan of planner breaks at the end: In(ball_1, slot_2)")


def test_the_plan_file_of_an_earlier_call_is_never_read(tmp_path: Path) -> None:
    done = str(tmp_path / "done")
    once = f"import os\nif not os.path.exists({done!r}):\n    write(PLAN)\n    open({done!r}, 'w')"
    planner = script(tmp_path, once)

    with Bench(tiny_world(), planner=planner) as bench:
        first = bench.plan(GOAL).outcome
        with pytest.raises(PlanningError, match="planner found no plan, and no proof that there is none: it left no"):
            bench.plan(GOAL)

    assert isinstance(first, Plan)


@pytest.mark.parametrize("place", ["/tmp/plan", "../plan"])
def test_a_plan_file_outside_the_folder_of_the_call_is_refused(place: str) -> None:
    with pytest.raises(UsageError, match="must be a file in the folder where the planner runs"):
        CommandPlanner("it", "it {domain} {problem}", plan=place)


# ------------------------------------------------------------------ another planner helps


@pytest.mark.parametrize(
    ("text", "note"),
    [
        ("sys.exit(1)", "planner 'planner_a' ended with code 1"),
        ("write('garbage')", "planner 'planner_a' wrote a plan whose line 1 is no step"),
        ("pass", "planner_a found no plan, and no proof that there is none"),
        ("write(PLAN[:90])", "the plan of planner_a breaks at the end"),
        ("import os; os.kill(os.getpid(), 11)", "planner 'planner_a' was killed by SIGSEGV"),
    ],
)
def test_after_a_planner_fails_the_next_suitable_one_is_asked(tmp_path: Path, text: str, note: str) -> None:
    bad, good = script(tmp_path, text, "planner_a"), script(tmp_path, "write(PLAN)", "planner_b")

    found = planned(bad, good)

    assert isinstance(found.outcome, Plan)
    assert found.planner == "planner_b"
    assert len(found.notes) == 1
    assert found.notes[0].startswith(note)


def test_after_a_proof_that_there_is_no_plan_no_other_planner_is_asked(tmp_path: Path) -> None:
    marker = tmp_path / "asked"
    other = script(tmp_path, f"open({str(marker)!r}, 'w')", "planner_b")

    found = planned(Kairos(), other, goal="In(ball_1, slot_1) and In(ball_1, slot_2)")

    assert isinstance(found.outcome, NoPlan)
    assert found.planner == "kairos"
    assert not marker.exists()


def test_if_all_planners_fail_each_is_named(tmp_path: Path) -> None:
    words = fault(script(tmp_path, "sys.exit(4)", "planner_a"), script(tmp_path, "sys.exit(5)", "planner_b"))

    assert "planner 'planner_a' ended with code 4" in words
    assert "planner 'planner_b' ended with code 5" in words


# ------------------------------------------------------------------ nothing is left running


@pytest.mark.parametrize(
    "text",
    [
        f"{STUBBORN}time.sleep(3600)",
        "import os, time\nfor _ in range(5):\n    if os.fork() == 0: time.sleep(3600)\ntime.sleep(3600)",
        f"{LEAVES_GROUP}time.sleep(3600)",
        "import os, time\nos.close(1); os.close(2)\ntime.sleep(3600)",
        "import time\nwhile True: print('working', flush=True)",
        "import os\nos.mkdir('locked'); open('locked/x', 'w'); os.chmod('locked', 0)\nimport time; time.sleep(3600)",
    ],
    ids=["ignores SIGTERM", "children", "children of their own group", "closed output", "chatters", "locked folder"],
)
def test_any_planner_program_is_stopped_promptly_with_all_its_processes(tmp_path: Path, text: str) -> None:
    planner = script(tmp_path, text)
    texts = tiny_pddl(tiny_world(), IN_CONTAINER("ball_1", "slot_1"))
    pending = planner.solve(texts.domain, texts.problem)
    wait_for(lambda: strays(tmp_path))
    time.sleep(0.1)

    pending.cancel()

    with pytest.raises(PlanningError, match="was stopped"):
        pending.result()
    planner.close()


@pytest.mark.parametrize("text", [LEAVES_GROUP, "import os, time\nif os.fork() == 0: time.sleep(3600)\n"])
def test_processes_left_behind_by_a_planner_are_killed(tmp_path: Path, text: str) -> None:
    assert isinstance(planned(script(tmp_path, f"{text}write(PLAN)")).outcome, Plan)


def test_a_stop_during_planning_kills_the_planner_at_once(tmp_path: Path) -> None:
    planner = script(tmp_path, f"{STUBBORN}time.sleep(3600)")
    robots = tuple(Capability(skill.description, ("robot_1", "base_1", "arm_1")) for skill in SKILLS)
    host = ThreadHost(tiny_world(), planner)
    planning = host.ask(PlanRequest((IN_CONTAINER("ball_1", "slot_1"),), tuple(robots)))
    wait_for(lambda: strays(tmp_path))

    planning.cancel()

    wait_for(lambda: not strays(tmp_path))
    planner.close()
    host.close()


def test_closing_twice_and_while_calls_wait_and_run_ends_all_of_them(tmp_path: Path) -> None:
    planner = script(tmp_path, "import time\ntime.sleep(3600)")
    pending = [planner.solve("", "") for _ in range(20)]
    wait_for(lambda: strays(tmp_path))

    planner.close()
    planner.close()

    for call in pending:
        with pytest.raises(PlanningError, match="was stopped"):
            call.result()
    with pytest.raises(PlanningError, match="was stopped"):
        planner.solve("", "")


def test_the_number_of_open_files_does_not_grow(tmp_path: Path) -> None:
    planner = script(tmp_path, "sys.exit(1)")
    counts = []
    for _ in range(3):
        for call in [planner.solve("", "") for _ in range(4)]:
            with pytest.raises(PlanningError):
                call.result()
        counts.append(len(list(Path("/proc/self/fd").iterdir())))
    planner.close()

    assert counts[-1] <= counts[0]


def test_a_planner_that_is_killed_from_outside_is_a_fault(tmp_path: Path) -> None:
    planner = script(tmp_path, "import time\ntime.sleep(3600)")
    pending = planner.solve("", "")
    wait_for(lambda: strays(tmp_path))

    for child in psutil.Process().children():
        if child.pid not in _BEFORE:
            child.kill()

    with pytest.raises(PlanningError, match="was killed by SIGKILL"):
        pending.result()
    planner.close()


def wait_for(what: object) -> None:
    deadline = time.monotonic() + 20.0
    while not what():  # type: ignore[operator]
        assert time.monotonic() < deadline, "it did not happen"
        time.sleep(0.01)


def test_a_planner_answer_without_a_proof_proves_nothing(tmp_path: Path) -> None:
    planner = script(tmp_path, "print('no solution')")

    answer = planner.solve("", "").result()
    planner.close()

    assert answer == Unsolvable("it left no plan, and ended with code 0:\nno solution", proven=False)
