"""Puts a body of a running simulation where, and makes it what, it is believed to be."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from skiros_py.errors import UsageError
from skiros_py.ports.cell import BodySpec
from skiros_py.simulation.pybullet.spawn import free_pose

if TYPE_CHECKING:
    from skiros_py.simulation.pybullet.cell import PyBulletCell

__all__ = ["put"]


def put(cell: PyBulletCell, name: str, body: BodySpec | None, *, moved: bool, seed: int) -> None:
    """Brings a body in, takes it away, moves it, or makes it anew where its shape or mass is another one.

    Args:
        cell: The simulation.
        name: Id of the body.
        body: How it is believed to be; None where it is gone.
        moved: Whether it shall be where it is believed to be; else it stays where it is, or away.
        seed: For a pose that nobody has said.

    Raises:
        UsageError: It is bolted to a robot, or shall be: only a new session does that.
        DescriptionError: There is no room for it where it shall lie.
    """
    scene = cell.scene
    there = scene.bodies.get(name)
    if there is not None and there.constraint is not None and (body is None or moved):
        raise UsageError(f"it is bolted to {there.spec.carrier}: reset the simulation, and it is brought up like that")
    if body is None:
        _take_away(cell, name)
    elif body.compartment:
        _fit(cell, body)
    elif body.carrier is not None:
        raise UsageError(f"it rides on {body.carrier}: reset the simulation, and it is brought up like that")
    elif there is None:
        if moved:
            _bring(cell, body, seed)
    elif not _alike(there.spec, body):
        pose = None if moved else scene.pose(name)
        cell.remove_body(name)
        _bring(cell, body if pose is None else replace(body, pose=pose), seed)
    elif moved:
        others = [(spec, pose) for spec, pose in scene.standing() if spec.id != name]
        cell.move_body(name, free_pose(body, others, seed))
        scene.bodies[name] = replace(there, spec=body)


def _bring(cell: PyBulletCell, body: BodySpec, seed: int) -> None:
    cell.add_body(replace(body, pose=free_pose(body, cell.scene.standing(), seed)))


def _take_away(cell: PyBulletCell, name: str) -> None:
    if name in cell.scene.bodies:
        cell.remove_body(name)
    cell.scene.compartments.pop(name, None)


def _fit(cell: PyBulletCell, compartment: BodySpec) -> None:
    """A compartment is a region of the body that has it: it moves with that one."""
    whole = cell.scene.bodies.get(compartment.place or "")
    if whole is not None and compartment.pose is not None and whole.spec.pose is not None:
        cell.scene.fit(compartment, whole.spec.pose.inverse() @ compartment.pose)


def _alike(one: BodySpec, other: BodySpec) -> bool:
    return (one.solid, one.mass, one.type) == (other.solid, other.mass, other.type)
