"""The reasoner of reach: at which locations robots work that nothing moves."""

from __future__ import annotations

import math

from skiros_py.geometry import Pose
from skiros_py.messages import Message
from skiros_py.world.poses import map_pose
from skiros_py.world.reasoners.registry import Answer, Reasoner
from skiros_py.world.view import WorldView, pieces
from skiros_py.world.vocabulary import BASE, REACH, REACHES, SUPPORT_OFFSET


class ReachReasoner(Reasoner):
    """Compares how far a location is from a robot with how far its arms reach, both seen from above."""

    name = "reach"
    relations = frozenset({REACHES})

    def answer(self, view: WorldView, subject: str, relation: str, object_: str) -> Answer:  # noqa: ARG002 - the only one
        """Returns whether a robot works at a location from where it stands; the value is how much nearer it is [m]."""
        owned = pieces(view, subject)
        if any(view.ontology.is_a(view.element(piece).type, BASE) for piece in owned):
            return Answer(False, Message("{robot} drives to where it works", robot=subject))
        reach = max((far for piece in owned if isinstance(far := view.value(piece, REACH), float)), default=None)
        stands, there = map_pose(view, subject), _middle(view, object_)
        if reach is None or stands is None or there is None:
            return Answer(
                False,
                Message("no reach of {robot} is known, or no pose of it or of {place}", robot=subject, place=object_),
            )
        away = math.dist(stands.position[:2], there.position[:2])
        said = {"robot": subject, "place": object_, "away": away, "reach": reach}
        return Answer(
            away <= reach,
            Message("{place} is {away:.2f} m from {robot}, which reaches {reach:.2f} m", **said),
            reach - away,
        )


def _middle(view: WorldView, place: str) -> Pose | None:
    """Returns the pose in the map of the middle of a place, or of the area of it on which things lie."""
    pose, offset = map_pose(view, place), view.value(place, SUPPORT_OFFSET)
    if pose is None or not isinstance(offset, tuple):
        return pose
    return pose @ Pose((offset[0], offset[1], offset[2]))
