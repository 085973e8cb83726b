"""Entry points are loaded; what breaks is reported, whatever it does, and the others are there."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

from skiros_py.errors import UnknownName
from skiros_py.plugins.installation import installation, leaving_out
from skiros_py.plugins.loading import find_plugin, load_plugins
from skiros_py.plugins.plugin import PluginFault, by_cause

GROUP = "skiros.testing_only"


def test_plugins_are_loaded_in_the_order_of_their_names(site: Any) -> None:
    site.install("plug-b", {"testing_only": {"zebra": "plug_b:Z", "ant": "plug_b:A"}}, {"plug_b.py": "Z, A = 26, 1"})

    plugins, faults = load_plugins(GROUP)

    assert [(p.group, p.name, p.distribution, p.value) for p in plugins] == [
        (GROUP, "ant", "plug-b 0.3", 1),
        (GROUP, "zebra", "plug-b 0.3", 26),
    ]
    assert faults == ()


def test_an_import_that_does_not_end_is_interrupted_and_named(site: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("skiros_py.plugins.loading._LONGEST", 0.3)
    site.install("plug-good", {"testing_only": {"good": "plug_good:X"}}, {"plug_good.py": "X = 1"})
    site.install("plug-hang", {"testing_only": {"hang": "plug_hang:X"}}, {"plug_hang.py": "while True:\n    pass\n"})

    plugins, (fault,) = load_plugins(GROUP)

    assert [plugin.name for plugin in plugins] == ["good"]
    assert fault.distribution == "plug-hang 0.3"
    assert fault.reason.startswith("TimeoutError: loading plug-in hang of plug-hang 0.3 did not end within 0.3 s (in ")
    assert str(site.folder / "plug_hang.py") in fault.reason


def test_a_call_in_an_import_that_cannot_be_interrupted_is_named_while_it_lasts(
    site: Any, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("skiros_py.plugins.loading._LONGEST", 0.2)
    text = "import time\ntime.sleep(0.6)\n"
    site.install("plug-sleep", {"testing_only": {"sleep": "plug_sleep:X"}}, {"plug_sleep.py": text})

    load_plugins(GROUP)

    assert "loading plug-in sleep of plug-sleep 0.3 has not ended within 0.2 s (in <module>, " in caplog.text


LEAVING = """
import os, threading
from os import _exit
child = os.fork()
if child == 0:
    os._exit(5)
CODE = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
if CODE != 5:
    raise AssertionError(CODE)
os._exit(3)
"""


def test_an_import_that_ends_the_process_is_a_fault_and_its_child_processes_end_as_ever(site: Any) -> None:
    leave = os._exit
    site.install("plug-good", {"testing_only": {"good": "plug_good:X"}}, {"plug_good.py": "X = 1"})
    site.install("plug-exit", {"testing_only": {"exit": "plug_exit:X"}}, {"plug_exit.py": LEAVING})

    plugins, (fault,) = load_plugins(GROUP)

    assert [plugin.name for plugin in plugins] == ["good"]
    assert (fault.distribution, fault.reason) == (
        "plug-exit 0.3",
        "SystemExit: it tried to end the program: os._exit(3)",
    )
    assert os._exit is leave


def test_an_import_that_crashes_the_interpreter_shows_whose_code_it_was(site: Any) -> None:
    text = "import ctypes\nctypes.string_at(0)\n"
    site.install("plug-crash", {"testing_only": {"crash": "plug_crash:X"}}, {"plug_crash.py": text})
    program = "from skiros_py.plugins.loading import load_plugins; load_plugins('skiros.testing_only')"

    ended = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": str(site.folder)},
        capture_output=True,
        text=True,
        check=False,
    )

    assert ended.returncode < 0
    assert f'File "{site.folder / "plug_crash.py"}", line 2 in <module>' in ended.stderr


RUDE = "class Rude(BaseException):\n    def __str__(self): raise OSError\nraise Rude"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("import no_such_module_anywhere", "ModuleNotFoundError: No module named 'no_such_module_anywhere'"),
        ("def broken(:", "SyntaxError"),
        ("1 / 0", "ZeroDivisionError"),
        ("", "AttributeError"),
        ("import sys; sys.exit(3)", "SystemExit: 3"),
        ("raise GeneratorExit", "GeneratorExit: "),
        ("def f(): f()\nf()", "RecursionError"),
        (RUDE, "Rude, which does not say what"),
        ("raise ExceptionGroup('all', [OSError(), ValueError()])", "ExceptionGroup: all (2 sub-exceptions)"),
    ],
)
def test_a_plugin_that_fails_to_load_is_reported_and_affects_no_other(site: Any, text: str, reason: str) -> None:
    site.install("plug-good", {"testing_only": {"good": "plug_good:X"}}, {"plug_good.py": "X = 1"})
    module = f"plug_bad_{len(text)}"
    site.install("plug-bad", {"testing_only": {"bad": f"{module}:X"}}, {f"{module}.py": text})

    plugins, (fault,) = load_plugins(GROUP)

    assert [p.name for p in plugins] == ["good"]
    assert (fault.group, fault.name, fault.distribution) == (GROUP, "bad", "plug-bad 0.3")
    assert fault.reason.startswith(reason)
    assert fault.traceback.startswith("Traceback (most recent call last)") or "Exception Group" in fault.traceback
    assert fault.origin == str(site.folder / f"{module}.py")


@pytest.fixture
def handled(request: pytest.FixtureRequest) -> Iterator[None]:
    """Ctrl-C, handled as the test says; earlier tests may have left it otherwise."""
    before = signal.signal(signal.SIGINT, request.param)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("handled", [signal.default_int_handler], indirect=True)
def test_an_interrupt_by_the_user_during_an_import_stops_the_program(site: Any, handled: None) -> None:
    site.install("plug-c", {"testing_only": {"c": "plug_c:X"}}, {"plug_c.py": "raise KeyboardInterrupt"})

    with pytest.raises(KeyboardInterrupt):
        load_plugins(GROUP)


@pytest.mark.parametrize("handled", [lambda _number, _frame: None], indirect=True)
def test_an_interrupt_raised_by_a_plug_in_is_a_fault_of_the_plug_in(site: Any, handled: None) -> None:
    site.install("plug-d", {"testing_only": {"d": "plug_d:X"}}, {"plug_d.py": "raise KeyboardInterrupt"})

    _, faults = load_plugins(GROUP)

    assert ["KeyboardInterrupt" in fault.reason for fault in faults] == [True]


def test_output_of_a_plugin_during_import_does_not_mix_with_an_answer(
    site: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    site.install("plug-loud", {"testing_only": {"loud": "plug_loud:X"}}, {"plug_loud.py": "print('hello'); X = 1"})

    load_plugins(GROUP)

    assert capsys.readouterr() == ("", "hello\n")


def test_plugins_that_are_loaded_in_several_threads_leave_stdout_as_it_was(site: Any) -> None:
    slow = "import time\ntime.sleep({})\nTHING = 1\n"
    site.install(
        "slow-lab",
        {"slow_a": {"a": "slow_a:THING"}, "slow_b": {"b": "slow_b:THING"}},
        {"slow_a.py": slow.format(0.2), "slow_b.py": slow.format(0.4)},
    )
    before = sys.stdout
    threads = [threading.Thread(target=load_plugins, args=(f"skiros.slow_{name}",)) for name in "ab"]
    for thread in threads:
        thread.start()
        time.sleep(0.05)
    for thread in threads:
        thread.join()

    assert sys.stdout is before


def test_an_entry_point_of_a_distribution_that_is_half_removed_is_called_stale(site: Any) -> None:
    site.install("plug-gone", {"testing_only": {"gone": "plug_gone.deep:X"}})

    (fault,) = load_plugins(GROUP)[1]

    assert "No module named 'plug_gone.deep': the entry point is stale" in fault.reason
    assert fault.reason.endswith("install plug-gone again, or uninstall it")


@pytest.mark.parametrize("value", ["not a reference", "mod:", ":obj", "mod:obj:more", ""])
def test_an_entry_point_that_names_nothing_is_reported(site: Any, value: str) -> None:
    site.install("plug-odd", {"testing_only": {"odd": value}})

    plugins, (fault,) = load_plugins(GROUP)

    assert plugins == ()
    assert fault.reason == f"'{value}' names nothing: write module:object"


def test_two_plug_ins_with_one_name_are_both_offered_under_names_that_their_distributions_qualify(site: Any) -> None:
    site.install("plug-one", {"testing_only": {"twin": "plug_one:X", "only": "plug_one:X"}}, {"plug_one.py": "X = 1"})
    site.install("Plug_Two", {"testing_only": {"twin": "plug_two:X"}}, {"plug_two.py": "X = 2"})

    plugins, faults = load_plugins(GROUP)

    assert [(plugin.name, plugin.own_name) for plugin in plugins] == [
        ("only", "only"),
        ("plug-one.twin", "twin"),
        ("plug-two.twin", "twin"),
    ]
    assert faults == ()
    assert find_plugin(GROUP, "plug-two.twin") == 2
    with pytest.raises(UnknownName, match=r"Did you mean 'plug-one\.twin'\?"):
        find_plugin(GROUP, "twin")


def test_a_built_in_plug_in_has_the_bare_name(site: Any) -> None:
    site.install("plug-one", {"testing_only": {"twin": "plug_one:X"}}, {"plug_one.py": "X = 1"})
    site.install("skiros-primitives", {"testing_only": {"twin": "plug_own:X"}}, {"plug_own.py": "X = 2"})

    assert {name: find_plugin(GROUP, name) for name in ("twin", "plug-one.twin")} == {"twin": 2, "plug-one.twin": 1}


def test_distributions_that_are_left_out_contribute_nothing_until_they_are_let_in_again(site: Any) -> None:
    site.install("plug-one", {"testing_only": {"twin": "plug_one:X"}}, {"plug_one.py": "X = 1"})
    site.install("plug-two", {"testing_only": {"twin": "plug_two:X"}}, {"plug_two.py": "X = 2"})

    with leaving_out(["Plug_Two"]):
        assert find_plugin(GROUP, "twin") == find_plugin(GROUP, "plug-one.twin") == 1
        assert "plug-two" in os.environ["SKIROS_WITHOUT"].lower().replace("_", "-")
    assert find_plugin(GROUP, "plug-two.twin") == 2
    with pytest.raises(UnknownName, match="Did you mean 'plug-two'"), leaving_out(["plug-too"]):
        pass


def test_one_distribution_with_two_entry_points_of_one_name_offers_neither(site: Any) -> None:
    info = site.install("plug-one", {}, {"plug_one.py": "X, Y = 1, 2"})
    (info / "entry_points.txt").write_text(f"[{GROUP}]\ntwin = plug_one:X\ntwin = plug_one:Y\n", encoding="utf-8")

    assert load_plugins(GROUP) == ((), ())
    assert {fault.name: "neither counts" in fault.reason for fault in installation().faults} == {"twin": True}


def test_a_group_without_plug_ins_is_empty() -> None:
    assert load_plugins("skiros.nobody_fills_this") == ((), ())


def test_one_failed_import_is_one_fault_that_names_every_plug_in_it_breaks() -> None:
    reason = "ModuleNotFoundError: No module named 'gone'"
    broken = [PluginFault("skiros.skills", f"skill_{n}", "sk-kit 0.3", reason, "") for n in range(22)]
    other = PluginFault("skiros.skills", "swim", "sk-sea 0.3", reason, "")

    first, last = by_cause([*broken, other])

    assert first.name == "skill_0"
    assert first.reason == (
        f"{reason} (the same breaks 21 other plug-ins: {', '.join(f'skill_{n}' for n in range(1, 11))}, and 11 more)"
    )
    assert last == other
