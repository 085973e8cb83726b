"""What is missing is said before anything starts, with the command that brings it."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from pathlib import Path

import pytest

from skiros_py.errors import MissingExtra, without_wheels
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.planners.unified import UnifiedPlanning
from skiros_py.system import EXTRAS, default_simulation, has_extra, require_extra

HIDING = """
import importlib.abc, sys

class Hidden(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {modules}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

hidden = Hidden()
sys.meta_path.insert(0, hidden)
import importlib.util
found = importlib.util.find_spec
importlib.util.find_spec = lambda name, *of: None if name.partition(".")[0] in {modules} else found(name, *of)
sys.argv = {arguments}
from skiros_py.cli.main import main
main()
"""


SERVED = """
import pathlib
from skiros_py.station.robots.models import RobotModels
from skiros_py.server.app import create_app  # everything that a server imports
from skiros_py.errors import MissingExtra, without_wheels
try:
    RobotModels(pathlib.Path(".")).get("mobile_panda")
except MissingExtra as error:
    print(error)
"""


def without(*modules: str) -> Callable[[str], ModuleSpec | None]:
    """Returns ``find_spec`` as it answers where some modules are not installed."""
    return lambda name: None if name in modules else find_spec(name)


def skiros_without(extra: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Runs the command line in an environment that lacks an extra."""
    program = HIDING.format(modules=set(EXTRAS[extra]), arguments=["skiros", *arguments])
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.parametrize("extra", EXTRAS)
def test_an_extra_that_is_missing_is_named_with_the_command_that_installs_it(
    extra: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(EXTRAS, extra, ("no_such_module_of_anybody",))

    assert not has_extra(extra)
    monkeypatch.setattr("skiros_py.errors.without_wheels", lambda extra: ())
    with pytest.raises(MissingExtra, match=rf"pip install 'skiros-py\[{extra}\]'") as raised:
        require_extra(extra, "this")
    assert raised.value.extra == extra


@pytest.mark.parametrize(
    "arguments", [("serve", "kitting"), ("key", "list", "--data", ".")], ids=lambda arguments: str(arguments[0])
)
def test_commands_of_the_server_say_that_its_extra_is_missing(arguments: tuple[str, ...]) -> None:
    ended = skiros_without("server", *arguments)

    assert ended.returncode == 2
    assert "skiros-py[server]" in ended.stderr
    assert "Traceback" not in ended.stderr


def test_worlds_and_plans_need_no_extra(tmp_path: Path) -> None:
    ended = skiros_without("server", "scene", "list")

    assert ended.returncode == 0
    assert "kitting" in ended.stdout


def test_packages_without_a_wheel_for_this_python_are_named_with_the_platform_that_has_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    wanted = ['pin>=4; extra == "physics"', 'pybullet; python_version < "3" and extra == "physics"',
              'skiros-py[perception]; extra == "physics"', 'open3d-cpu; python_version < "3" and extra == "perception"',
              'numpy>=2']  # fmt: skip
    monkeypatch.setattr("importlib.metadata.requires", lambda name: wanted)
    monkeypatch.setitem(EXTRAS, "physics", ("no_such_module_of_anybody",))

    assert without_wheels("physics") == ("pybullet", "open3d-cpu")
    assert without_wheels("server") == ()
    with pytest.raises(MissingExtra, match=r"use Python 3.11 on x86-64 Linux, since pybullet, open3d-cpu cannot be"):
        require_extra("physics", "this")


def test_physics_is_for_a_python_without_pybullet_too(monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = ['mujoco-core>=4; extra == "physics"', 'skiros-py[pybullet]; python_version < "3" and extra == "physics"',
              'pybullet; python_version < "3" and extra == "pybullet"']  # fmt: skip
    monkeypatch.setattr("importlib.metadata.requires", lambda name: wanted)

    assert without_wheels("physics") == ()
    assert without_wheels("pybullet") == ("pybullet",)


def test_the_default_engine_is_pybullet_where_it_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    assert default_simulation() == "pybullet"

    monkeypatch.setattr("skiros_py.system.find_spec", without("pybullet"))

    assert default_simulation() == "mujoco"


def test_planners_that_are_not_installed_name_their_extra(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("skiros_py.planning.planners.unified.find_spec", without("unified_planning"))
    monkeypatch.setattr("skiros_py.planning.planners.kairos.sysconfig.get_path", lambda name: str(tmp_path))
    monkeypatch.setattr("skiros_py.planning.planners.kairos.files", lambda name: None)
    monkeypatch.setenv("PATH", str(tmp_path))

    for planner in (Kairos, UnifiedPlanning):
        with pytest.raises(MissingExtra, match=r"skiros-py\[planners\]"):
            planner()


def test_a_fake_station_is_served_without_physics_and_perception(tmp_path: Path) -> None:
    modules = {*EXTRAS["physics"], "pybullet_data", "coal"}
    program = HIDING.format(modules=modules, arguments=[]).replace(
        "from skiros_py.cli.main import main\nmain()\n", SERVED
    )
    ended = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path)], capture_output=True, text=True, timeout=120, check=False
    )

    assert ended.returncode == 0, ended.stderr
    assert "the model 'mobile_panda' needs the extra 'pybullet'" in ended.stdout
