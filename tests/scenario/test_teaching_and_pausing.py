"""What a person does beside the plan: pausing a motion, sending a robot home, showing it what nobody wrote down."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_py.catalogue import load_catalogue
from skiros_py.geometry import Pose
from skiros_py.planning.plan import NoPlan
from skiros_py.robot.motion import JointMove, LineMove, NoMotion, PoseMove
from skiros_py.runtime import Session
from skiros_py.simulation.truth import Truth
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution

pytestmark = pytest.mark.physics

SCENES = Path(__file__).parents[2] / "scenes"
PREFIXES = """
@prefix sk: <https://w3id.org/skiros-py/core#> . @prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdf: <http://www.w3.org/1999/02/22-rdf-syntax-ns#> . @prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix bars: <https://example.org/bars#> . @prefix scene: <https://w3id.org/skiros-py/scene#> .
"""
BARS = f"""{PREFIXES}
<https://example.org/bars> a owl:Ontology ; owl:imports <https://w3id.org/skiros-py/core> .
bars:Bar a owl:Class ; rdfs:subClassOf sk:Manipulatable ; rdfs:label "bar" ; rdfs:comment "Nobody said how to take it." ;
    sk:mass 0.3 ; sk:solid '[{{"kind": "box", "size": [0.10, 0.04, 0.05], "at": [0, 0, 0.025]}}]'^^rdf:JSON .
"""
AWAY = (-2.6, -0.2, 0.4, -1.8, 0.3, 2.2, 0.2)
"""A posture far from home [rad]."""


class Guide(ArmPrimitive):
    """Stands in for the hand of a person that leads an arm."""

    name: ClassVar[str] = "guide"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param("sk:Arm", "The arm.", kind=Kind.HARDWARE)
        joints: tuple[float, ...] | None = param(
            "number", "Where to.", kind=Kind.OPTIONAL, default=None, length=7, unit="rad"
        )
        tip: Pose | None = param("pose", "Where to, from above.", kind=Kind.OPTIONAL, default=None)
        touching: tuple[str, ...] = param("text", "What may be touched.", kind=Kind.OFFLINE, default=(), length=0)

    def execute(self) -> Execution[Outcome]:
        """Moves."""
        if self.params.joints is not None:
            refusal = yield from self.go([(JointMove(self.params.joints),)])
        else:
            tip, may = self.params.tip, frozenset(self.params.touching)
            assert tip is not None
            down = LineMove(tip, touching=may)
            refusal = yield from self.go([(PoseMove(Pose((0.0, 0.0, 0.1)) @ tip), down)] if may else [(down,)])
        return Failure(refusal.reason) if isinstance(refusal, NoMotion) else Success()


@pytest.fixture
def open_guided(open_session: Callable[..., Session]) -> Iterator[Callable[..., Session]]:
    """Opens a session in which a person may lead the arm."""
    catalogue = load_catalogue()
    primitives = {**catalogue.primitives, "guide": Guide}

    def open_(scene: str, **options: Any) -> Session:
        return open_session(scene, catalogue=replace(catalogue, primitives=primitives), **options)

    return open_
