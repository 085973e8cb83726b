"""Plug-ins that are broken are told with their origin and hurt nobody else."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from skiros_py.station.session import Options, Session
from skiros_py.testing import (
    TINY_ONTOLOGY,
    tiny_scene,
)

Install = Callable[[str, Mapping[str, Mapping[str, str]], str], None]

GOOD = """
from dataclasses import replace
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, pretend
HOP = pretend(replace(DRIVE, name="hop"))
AT = AT_LOCATION
"""


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Installs a distribution with entry points by group, and one module."""
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(TINY_ONTOLOGY))
    site = tmp_path / "site"
    site.mkdir()
    monkeypatch.syspath_prepend(str(site))

    def make(name: str, groups: Mapping[str, Mapping[str, str]], text: str) -> None:
        info = site / f"{name}-0.3.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 0.3\n", encoding="utf-8")
        lines = []
        for group, points in groups.items():
            lines += [f"[skiros.{group}]", *(f"{key} = {name}:{value}" for key, value in points.items())]
        (info / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
        (site / f"{name}.py").write_text(text, encoding="utf-8")

    return make


def faults_of(session: Session, distribution: str) -> dict[str, str]:
    session.catalogue.load_all()
    return {f.name: f"{f.reason}\n{f.traceback}" for f in session.catalogue.faults if distribution in f.distribution}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("raise ValueError('not today')", "not today"),
        ("import sys; sys.exit(5)", "SystemExit"),
        ("raise SystemExit", "SystemExit"),
        ("class Own(BaseException): pass\nraise Own('mine')", "mine"),
        ("raise GeneratorExit", "GeneratorExit"),
        ("import no_such_library", "no_such_library"),
        ("def f(: pass", "SyntaxError"),
        ("def f(): f()\nf()", "RecursionError"),
        ("from skiros_py.skills.skill import SkillDescription\nSkillDescription('', '', '', '', ())", "skill name"),
    ],
)
def test_a_plug_in_that_raises_on_import_is_reported_with_its_origin_and_affects_no_other(
    install: Install, tmp_path: Path, text: str, told: str
) -> None:
    install("sk_fine", {"skills": {"hop": "HOP"}, "conditions": {"TinyAt": "AT"}}, GOOD)
    install("sk_awful", {"skills": {"dive": "DIVE"}, "primitives": {"swim": "Swim"}, "conditions": {"Wet": "W"}}, text)

    with Session(str(tiny_scene(tmp_path)), Options(fake=True)) as session:
        faults = faults_of(session, "sk_awful 0.3")
        assert set(faults) == {"dive", "swim", "Wet"}
        assert all(told in fault for fault in faults.values())
        assert session.run(["TinyAt(robot_1, box_a)"]).reached


ODD_PRIMITIVES = """
from dataclasses import dataclass
from skiros_py.skills.primitive import Primitive

class NoParams(Primitive):
    name = "no_params"
    def execute(self):
        yield

class NoName(Primitive):
    @dataclass(frozen=True)
    class Params:
        pass
    def execute(self):
        yield

class NoExecution(Primitive):
    name = "no_execution"
    @dataclass(frozen=True)
    class Params:
        pass

class NoDataclass(Primitive):
    name = "no_dataclass"
    class Params:
        arm = 5
    def execute(self):
        yield

class Undeclared(Primitive):
    name = "undeclared"
    @dataclass(frozen=True)
    class Params:
        arm: str = "arm_1"
    def execute(self):
        yield
"""


def test_incomplete_primitives_are_reported_and_affect_no_other(install: Install, tmp_path: Path) -> None:
    install("sk_fine", {"skills": {"hop": "HOP"}, "conditions": {"TinyAt": "AT"}}, GOOD)
    names = {
        "no_params": "NoParams",
        "no_name": "NoName",
        "no_execution": "NoExecution",
        "no_dataclass": "NoDataclass",
        "undeclared": "Undeclared",
    }
    install("sk_odd", {"primitives": names}, ODD_PRIMITIVES)

    with Session(str(tiny_scene(tmp_path)), Options(fake=True)) as session:
        assert set(faults_of(session, "sk_odd")) == set(names)
        assert session.run(["TinyAt(robot_1, box_a)"]).reached


def test_two_modules_with_the_same_name_are_both_offered_and_qualified_by_their_distributions(
    install: Install, tmp_path: Path
) -> None:
    install("sk_fine", {"skills": {"hop": "HOP"}, "conditions": {"TinyAt": "AT"}}, GOOD)
    for name in ("sk_this", "sk_other"):
        text = GOOD.replace("HOP", "SKIP").replace('name="hop"', f'name="skip", help="As {name} does."')
        install(name, {"skills": {"skip": "SKIP"}}, text)

    with Session(str(tiny_scene(tmp_path)), Options(fake=True)) as session:
        assert {**faults_of(session, "sk_this"), **faults_of(session, "sk_other")} == {}
        assert {"hop", "sk-this.skip", "sk-other.skip"} <= set(session.managers["base_1"].descriptions)
        assert session.run(["TinyAt(robot_1, box_a)"]).reached


def test_a_skill_and_a_primitive_with_the_same_name_are_both_offered_too(install: Install, tmp_path: Path) -> None:
    install("sk_fine", {"skills": {"hop": "HOP"}, "conditions": {"TinyAt": "AT"}}, GOOD)
    primitive = """
from dataclasses import dataclass
from skiros_py.skills.primitive import Primitive
class Hop(Primitive):
    \"\"\"Hops.\"\"\"
    name = "hop"
    @dataclass(frozen=True)
    class Params:
        pass
    def execute(self):
        yield
"""
    install("sk_same", {"primitives": {"hop": "Hop"}}, primitive)

    with Session(str(tiny_scene(tmp_path)), Options(fake=True)) as session:
        assert {**faults_of(session, "sk_fine"), **faults_of(session, "sk_same")} == {}
        assert "sk-fine.hop" in session.managers["base_1"].descriptions
        assert "sk-same.hop" in session.managers["base_1"].modules


def test_a_plug_in_primitive_that_raises_mid_run_fails_the_goal_with_a_reason_and_the_session_continues(
    install: Install, tmp_path: Path
) -> None:
    install("sk_fine", {"skills": {"hop": "HOP"}, "conditions": {"TinyAt": "AT"}}, GOOD)
    broken = """
from dataclasses import dataclass, replace
from skiros_py.behaviours import Do
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.conditions import ConditionType, Related, Role
from skiros_py.testing.tiny import DRIVE, pretend
KNOWS = ConditionType("Knows", (Role("robot", "sk:Robot"), Role("place", "sk:Location")),
                      Related("tiny:knows", "robot", "place"), "Was there.")
LEARN = pretend(replace(DRIVE, name="learn", post=(KNOWS("Robot", "Location"),)), Do.of("stumble"))
class Stumble(Primitive):
    \"\"\"Stumbles.\"\"\"
    name = "stumble"
    @dataclass(frozen=True)
    class Params:
        pass
    def execute(self):
        yield
        import sys
        sys.exit("stumbled")
"""
    points = {"skills": {"learn": "LEARN"}, "primitives": {"stumble": "Stumble"}, "conditions": {"Knows": "KNOWS"}}
    install("sk_stumbling", points, broken)

    with Session(str(tiny_scene(tmp_path)), Options(fake=True)) as session:
        report = session.run(["Knows(robot_1, box_a)"])

        assert not report.reached
        assert "stumble" in str(report)
        assert "stumbled" in str(report)
        assert session.run(["TinyAt(robot_1, box_a)"]).reached
