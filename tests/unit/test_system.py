"""What is missing is said before anything starts, with the command that brings it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from skiros_py.errors import MissingExtra
from skiros_py.system import EXTRAS, has_extra, require_extra

HIDING = """
import importlib.abc, sys

class Hidden(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {modules}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Hidden())
sys.argv = {arguments}
from skiros_py.cli.main import main
main()
"""


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
