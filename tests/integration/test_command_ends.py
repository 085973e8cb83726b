"""The command ends, and says why, whatever the code of plug-ins does; its answer in JSON stays one object."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from skiros_py.cli.output import brief
from skiros_py.testing import TINY_ONTOLOGY, tiny_scene

Start = Callable[..., subprocess.Popen[str]]

HEAD = """
import ctypes, os, sys, threading, time
from dataclasses import dataclass, replace
from skiros_py.behaviours import Do
from skiros_py.skills.outcome import Success
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.conditions import ConditionType, Related, Role
from skiros_py.testing.tiny import DRIVE, pretend
KNOWS = ConditionType("Knows", (Role("robot", "sk:Robot"), Role("place", "sk:Location")),
                      Related("tiny:knows", "robot", "place"), "Was there.")
HOP = pretend(replace(DRIVE, name="hop", post=(KNOWS("Robot", "Location"),)), Do.of("leap"))
class Leap(Primitive):
    \"\"\"Leaps.\"\"\"
    name = "leap"
    @dataclass(frozen=True)
    class Params:
        pass
    def execute(self):
        yield
"""
RETURN = """
        return Success("leapt")
"""


@pytest.fixture
def start(tmp_path: Path) -> Start:
    """Starts the command beside a distribution whose primitive does something odd."""

    def begin(body: str, *arguments: str, more: str = "", points: str = "") -> subprocess.Popen[str]:
        info = tmp_path / "site" / "sk_leaping-0.3.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: sk-leaping\nVersion: 0.3\n", encoding="utf-8")
        own = "[skiros.skills]\nhop = sk_leaping:HOP\n[skiros.conditions]\nKnows = sk_leaping:KNOWS\n"
        text = f"{own}{points}\n[skiros.primitives]\nleap = sk_leaping:Leap\n"
        (info / "entry_points.txt").write_text(text, encoding="utf-8")
        code = f"{HEAD}        {body}{RETURN}{more}"
        (info.parent / "sk_leaping.py").write_text(code, encoding="utf-8")
        environment = {**os.environ, "PYTHONPATH": str(info.parent), "SKIROS_ONTOLOGIES": str(TINY_ONTOLOGY)}
        command = [sys.executable, "-m", "skiros_py.cli", *arguments]
        return subprocess.Popen(
            command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path
        )

    return begin


@pytest.fixture
def run(start: Start, tmp_path: Path) -> Start:
    """Starts a run in which that primitive is called."""
    scene = str(tiny_scene(tmp_path))

    def begin(body: str, *options: str) -> subprocess.Popen[str]:
        return start(body, "run", scene, "--fake", "--goal", "Knows(robot_1, box_a)", *options)

    return begin


def ended(process: subprocess.Popen[str], seconds: float = 40.0) -> tuple[int, str, str]:
    try:
        out, err = process.communicate(timeout=seconds)
    finally:
        process.kill()
    return process.returncode, out, err


IN_C = "ctypes.CDLL(None).sleep(100)"


@pytest.mark.parametrize("call", ["time.sleep(100)", IN_C])
def test_a_call_into_c_that_never_returns_ends_the_command_soon_after_its_manager_is_lost(
    run: Start, call: str
) -> None:
    begun = time.monotonic()
    status, out, err = ended(run(call, "--json"))

    assert status == 1, err
    assert "does not come back" in json.loads(out)["error"]
    assert "does not come back" in err
    assert time.monotonic() - begun < 25.0


@pytest.mark.parametrize("call", ["time.sleep(100)", IN_C])
def test_sigterm_ends_a_command_whose_control_thread_is_stuck(run: Start, call: str) -> None:
    process = run(f"print('stuck', flush=True); {call}")
    assert process.stdout is not None
    assert any("stuck" in line for line in process.stdout)
    begun = time.monotonic()
    process.send_signal(signal.SIGTERM)
    status, _, err = ended(process)

    assert status == 130, err
    assert time.monotonic() - begun < 6.0


def test_output_of_a_primitive_even_from_c_is_not_mixed_into_the_json_answer(run: Start) -> None:
    chatter = "print('chatter'); os.write(1, b'more chatter'); sys.stdout.write('and more')"
    status, out, err = ended(run(chatter, "--json"))

    assert status == 1, err
    assert json.loads(out)["reached"] is False
    assert "chatter" in err
    assert "more chatter" in err


def test_running_a_single_module_prints_exactly_one_json_object(start: Start, tmp_path: Path) -> None:
    scene = str(tiny_scene(tmp_path))
    status, out, err = ended(start("print('chatter')", "module", "run", "leap", "--scene", scene, "--fake", "--json"))

    assert status == 0, err
    assert json.loads(out)["runs"][0]["success"] is True
    assert "chatter" in err


def test_a_thread_that_a_primitive_leaves_behind_is_named_and_does_not_hold_the_command_open(run: Start) -> None:
    body = "threading.Thread(target=time.sleep, args=(100,), name='lingerer').start()"
    begun = time.monotonic()
    status, _, err = ended(run(body))

    assert status == 1, err
    assert "lingerer" in err
    assert time.monotonic() - begun < 25.0


def test_an_overrun_is_reported_in_one_line_with_the_line_of_the_plug_in(run: Start) -> None:
    status, _, err = ended(run("exec('while True: pass')"))

    assert status == 1, err
    assert "sk_leaping.py:" in err
    assert "in execute)" in err
    assert 'File "' not in err


EVIL_CLASS = """
class Meta(type(Primitive)):
    def __getattribute__(cls, name):
        raise SystemExit(0)
class Evil(Primitive, metaclass=Meta):
    pass
class Liar:
    @property
    def __class__(self):
        raise SystemExit(0)
LIAR = Liar()
"""
EVIL_POINTS = (
    "liar = sk_leaping:LIAR\n[skiros.reasoners]\nevil = sk_leaping:LIAR\n[skiros.robots]\nevil = sk_leaping:LIAR"
)


@pytest.mark.parametrize("command", ["plugins", "skills", "doctor", "check-plugin"])
def test_a_plug_in_object_that_raises_system_exit_does_not_end_the_command(start: Start, command: str) -> None:
    points = f"{EVIL_POINTS}\n[skiros.planners]\nliar = sk_leaping:LIAR"
    more = EVIL_CLASS.replace("class Evil(", "class Leap2(") + "\nLeap = Leap2\n"
    status, out, err = ended(start("pass", command, more=more, points=points), 60.0)

    assert status in (0, 1), err
    assert "SystemExit" in out + err
    assert "leap" in out + err


def test_a_keyboard_interrupt_raised_by_a_plug_in_is_a_fault_and_not_a_request_of_the_user(start: Start) -> None:
    status, out, err = ended(start("pass", "plugins", more="raise KeyboardInterrupt\n"))

    assert status == 1, err
    assert "KeyboardInterrupt" in out


def test_a_text_without_a_stack_is_unchanged() -> None:
    assert brief("first\nsecond") == "first\nsecond"


def test_a_text_with_a_stack_keeps_the_innermost_line_outside_the_platform_and_python() -> None:
    stack = f'  File "/own/skill.py", line 3, in hop\n  File "{json.__file__}", line 9, in loads'

    assert brief(f"it broke\n{stack}") == "it broke (/own/skill.py:3 in hop)"


def test_a_closed_output_pipe_ends_the_command_silently() -> None:
    for arguments in (("scene", "show", "kitting"), ("world", "query", "kitting", "SELECT * {?a ?b ?c}")):
        with subprocess.Popen(
            [sys.executable, "-m", "skiros_py.cli", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as process:
            assert process.stdout is not None
            assert process.stderr is not None
            process.stdout.close()
            said = process.stderr.read()

        assert (said, process.returncode) == ("", 130)
