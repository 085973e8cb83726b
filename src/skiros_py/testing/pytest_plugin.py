"""The pytest plug-in: fixtures for tests of skills, and a full account of every trial in a test that failed.

Every pytest of an environment loads it, so nothing heavy is imported before a fixture is used.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from skiros_py.station.session import Session
    from skiros_py.testing import Bench, SkillTrial
    from skiros_py.world.world import World

_MARKER = "skiros_scene"
_NO_SCENE = (
    "which scene? mark the test with @pytest.mark.skiros_scene(name, path or Turtle), "
    "or set skiros_scene in the ini file"
)
_trials: pytest.StashKey[list[SkillTrial]] = pytest.StashKey()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Makes the ini option known."""
    parser.addini(_MARKER, "name, path or Turtle of the scene of tests that do not say one", default="")


def pytest_configure(config: pytest.Config) -> None:
    """Makes the marker known."""
    config.addinivalue_line(
        "markers", f"{_MARKER}(scene, **options): the test's world: name or path of a scene, or Turtle; see world_of"
    )


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Adds every trial of a failed test to its report: how it ended, the tree of reasons, events, changes."""
    report = yield
    if report.when == "call" and report.failed:
        for trial in item.stash.get(_trials, []):
            report.sections.append((f"skiros: {trial!r}", str(trial)))
    return report


@pytest.fixture
def skiros_world(request: pytest.FixtureRequest) -> World:
    """The world of the test's scene, with the installed ontologies; created for each test."""
    from skiros_py.testing import world_of

    marker = request.node.get_closest_marker(_MARKER)
    return world_of(_scene(request), **(marker.kwargs if marker else {}))


@pytest.fixture
def skiros_bench(skiros_world: World) -> Iterator[Bench]:
    """A bench on the test's scene with everything that is installed: skills, primitives, conditions."""
    from skiros_py.catalogue import fitting, load_catalogue
    from skiros_py.testing import Bench

    found = fitting(load_catalogue(), skiros_world.ontology, skiros_world.reasoners, fake=True)
    skills = list(found.skills.values())
    with Bench(skiros_world, skills, found.primitives, conditions=found.conditions) as bench:
        yield bench


@pytest.fixture
def skiros_session(request: pytest.FixtureRequest) -> Iterator[Session]:
    """A session on the test's scene (a name or a path), on the fake robot."""
    from skiros_py.station.session import Options, Session

    with Session(_scene(request), Options(fake=True)) as session:
        yield session


@pytest.fixture
def run_skill(request: pytest.FixtureRequest) -> Callable[..., SkillTrial]:
    """:func:`skiros_py.testing.run_skill`; if the test fails, its report describes the trial.

    If the world is omitted, that of the test's scene is used, the same for all calls of a test.
    """
    from skiros_py.testing import run_skill

    return _reporting(request, run_skill)


@pytest.fixture
def run_primitive(request: pytest.FixtureRequest) -> Callable[..., SkillTrial]:
    """:func:`skiros_py.testing.run_primitive`, as :func:`run_skill`."""
    from skiros_py.testing import run_primitive

    return _reporting(request, run_primitive)


def _scene(request: pytest.FixtureRequest) -> str:
    marker = request.node.get_closest_marker(_MARKER)
    scene = str(marker.args[0]) if marker and marker.args else str(request.config.getini(_MARKER))
    if not scene:
        pytest.fail(_NO_SCENE, pytrace=False)
    return scene


def _reporting(request: pytest.FixtureRequest, run: Callable[..., SkillTrial]) -> Callable[..., SkillTrial]:
    def runner(module: Any, world: World | None = None, **arguments: Any) -> SkillTrial:
        trial = run(module, world or request.getfixturevalue("skiros_world"), **arguments)
        request.node.stash.setdefault(_trials, []).append(trial)
        return trial

    return runner
