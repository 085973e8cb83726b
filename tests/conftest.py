"""What all tests share.

Numerics run on one thread, as in the worker processes: results do not depend on the number of cores. That is set before
any test module loads a numerical library, which read it once. Compiled modules are kept, even if the environment
says otherwise: hundreds of child processes would compile the platform again.

``pytest`` alone runs the whole suite on several cores: a file with the fixtures of its module stays in one process, and
so do all tests with physics and all tests in a browser, which would take each other's time. A run of named files or
folders stays in one process unless ``-n`` is given.
"""

import gc
import os
import sys
from collections.abc import Generator, Iterator, Mapping, Sequence
from pathlib import Path

import hypothesis
import pytest
from xdist.remote import Producer
from xdist.scheduler import LoadScopeScheduling

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

hypothesis.settings.register_profile("without-deadline", deadline=None)  # how long an example takes is no claim
hypothesis.settings.load_profile("without-deadline")

_MOST_WORKERS = 4
"""Each has servers and simulations of its own, with up to 2 GB."""
_ONE_BY_ONE = ("tests/scenario/", "tests/web/")
"""Folders whose tests run one after the other: physics, and a browser."""


class _Scheduler(LoadScopeScheduling):
    """Gives a process whole files, or all of a folder whose tests run one after the other."""

    def _split_scope(self, nodeid: str) -> str:
        return next((folder for folder in _ONE_BY_ONE if nodeid.startswith(folder)), nodeid.partition("::")[0])


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> LoadScopeScheduling:
    return _Scheduler(config, log)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Returns the number of processes for the whole suite; 0 for a part of it, which runs in this one."""
    whole = config.args_source is pytest.Config.ArgsSource.TESTPATHS
    # One more than there are cores: tests of servers and of killed processes wait for a quarter of their time.
    return min(_MOST_WORKERS, len(os.sched_getaffinity(0)) + 1) if whole else 0


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collects without the garbage collector, and keeps it off the half a million objects of modules and tests."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.collect()
        gc.freeze()
        gc.enable()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Begins with what takes longest in one process where there are several."""
    if hasattr(config, "workerinput"):
        items.sort(key=lambda item: not item.nodeid.startswith(_ONE_BY_ONE))


class Site:
    """A folder on Python's path with distributions as pip would leave them behind."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def install(
        self,
        name: str,
        groups: Mapping[str, Mapping[str, str]],
        files: Mapping[str, str] | None = None,
        *,
        version: str = "0.3",
        requires: Sequence[str] = (),
    ) -> Path:
        """Installs a distribution.

        Args:
            name: Its name.
            groups: Entry points by group, without "skiros.".
            files: Text by path: its modules and data.
            version: Its version.
            requires: What it requires.

        Returns:
            The folder of its metadata.
        """
        info = self.folder / f"{name.replace('-', '_')}-{version}.dist-info"
        info.mkdir()
        head = f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n"
        (info / "METADATA").write_text(head + "".join(f"Requires-Dist: {r}\n" for r in requires), encoding="utf-8")
        points = (f"[skiros.{g}]\n" + "".join(f"{n} = {v}\n" for n, v in own.items()) for g, own in groups.items())
        (info / "entry_points.txt").write_text("".join(points), encoding="utf-8")
        for file, text in (files or {}).items():
            path = self.folder / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        return info


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Site]:
    """An empty folder on Python's path in which distributions can be installed; their modules go with the test."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(str(folder))
    yield Site(folder)
    for name, module in list(sys.modules.items()):
        if str(getattr(module, "__file__", "")).startswith(str(folder)):
            del sys.modules[name]
