"""Contract tests in physics: the declared effects must also hold for the simulated bodies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import replace

from skiros_py.catalogue import Catalogue
from skiros_py.checking.cases import Case, Ground, NoCase, find_case
from skiros_py.checking.contract import Contract, contained_contract, finding, missing_effects, never_tried
from skiros_py.checking.rig import Rig
from skiros_py.skills.lint import EFFECT_MISSING, Spot
from skiros_py.skills.outcome import Outcome
from skiros_py.skills.skill import Skill
from skiros_py.station.judgement import judge
from skiros_py.station.session import Options, Session
from skiros_py.station.worlds import open_world

_DRIVER = "pybullet"


def is_simulable(skill: Skill) -> bool:
    """Returns whether a skill can be run in the simulation: only those for every robot."""
    return skill.driver in (None, _DRIVER)


def check_simulated(skill: Skill, scene: str, catalogue: Catalogue, spot: Spot | None = None) -> Contract:
    """Runs a skill in physics, in a reachable state, and compares its effects with the ground truth.

    Other changes of the world are ignored, because a robot with cameras updates its beliefs wherever it goes.

    Args:
        skill: The implementation.
        scene: Name or path of the scene.
        catalogue: Everything installed.
        spot: Its location in the source.
    """
    ground = Ground(scene, lambda: open_world(scene))
    others = {key: one for key, one in catalogue.skills.items() if one.description.name != skill.description.name}
    alone = replace(catalogue, skills={**others, _key(skill, catalogue.skills): skill})
    simulable = [one for one in alone.skills.values() if is_simulable(one)]

    def tried() -> Contract:
        with ExitStack() as stack:
            sessions: list[Session] = []

            def rig_in(_ground: Ground) -> Rig:
                sessions.append(stack.enter_context(Session(scene, Options(), catalogue=alone)))
                return Rig(sessions[-1].runtime)

            case = find_case(skill, [ground], simulable, rig_in, may_make_up=False)
            if isinstance(case, NoCase):
                return never_tried(skill, case.reason, spot)
            session = next(one for one in sessions if one.world is case.rig.world)
            return _judged(skill, case, session, spot)

    return contained_contract(skill, spot, tried)


def _key(skill: Skill, skills: Mapping[str, Skill]) -> str:
    return next((key for key, one in skills.items() if one == skill), skill.description.name)


def _judged(skill: Skill, case: Case, session: Session, spot: Spot | None) -> Contract:
    outcome = case.rig.run(case.agent, skill.description.name, case.arguments)
    with case.rig.watched():
        texts = [*missing_effects(skill, case, outcome), *_untrue(skill, case, outcome, session)]
    where = f"{case.where}, simulated"
    findings = tuple(finding(EFFECT_MISSING, skill, f"{text} ({where})", spot) for text in texts)
    return Contract(skill, findings, where, case.arguments, outcome)


def _untrue(skill: Skill, case: Case, outcome: Outcome, session: Session) -> Iterator[str]:
    """Yields the postconditions that the robot believes but that do not hold in the simulator."""
    posts = [condition.bind(case.arguments) for condition in skill.description.post]
    for condition, truth in zip(posts, judge(session.simulation, session.spec, session.world, posts), strict=True):
        if truth is False and condition.evaluate(session.world):
            yield f"{condition} is believed, and is not so: it ended with {outcome}"
