"""Generated scenes for ``benchmarks/rehearsal.py``: each kind with a geometric trap, and the same one without."""

from __future__ import annotations

import math

from manipulation_scenes import KNOWN, Chance, PartType, Scene, box, individual, kit, part, storage

from skiros_py.geometry import Pose, Primitive

KINDS = ("low shelf", "wall", "out of reach", "narrow passage")
"""A board above a part, a block over a compartment, a part far from each edge, a wall with a gap around a place."""
_AT = (0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0)
"""Directions of the place with the trap, of the other place and of the kit [rad]."""
_SUPPORT = (-0.07, 0.0)
"""Middle of the surface of a place, in its frame [m]."""


def scene(seed: int, *, trap: bool) -> Scene:
    """Returns a scene in which a part is wanted in a kit.

    Every second of each kind has another part of the class, or another compartment, with which the goal can be reached
    in spite of the trap.

    Args:
        seed: Its seed; the kinds take turns.
        trap: Whether there is a trap.
    """
    chance, number = Chance(seed), seed // 2
    kind, other_way = KINDS[number % len(KINDS)], number // len(KINDS) % 2 == 0
    wanted = chance.some(KNOWN, 1)[0]
    height = chance.within(0.45, 0.65)
    place, other, table = _spots(chance, distance=3.4 if kind == "narrow passage" else 2.6)
    text = kit(table, chance.within(0.45, 0.6), 0.0)
    goal = f"ObjectAtLocation({wanted.label}, kit_1_a)"
    if kind == "wall":
        text += [storage("pallet_1", place, height), part("part_1", wanted, "pallet_1")]
        text.append(_cover(chance, text, table, trap=trap))
        if other_way:
            goal = f"InKit({wanted.label}, kit_1)"
        return _made(seed, kind, text, goal, trap=trap, other_way=other_way)
    # Of parts alike a planner takes the last one first, so that is the one in the trap.
    text += _trapped(chance, kind, place, height, wanted, trap=trap)
    if other_way:
        text += [storage("pallet_1", other, chance.within(0.45, 0.65)), part("part_1", wanted, "pallet_1")]
    return _made(seed, kind, text, goal, trap=trap, other_way=other_way)


def _made(seed: int, kind: str, text: list[str], goal: str, *, trap: bool, other_way: bool) -> Scene:
    name = f"{kind.replace(' ', '_')}_{'trap' if trap else 'free'}_{seed}"
    return Scene(name, seed, f"{kind}{', another way' if other_way else ''}", (), tuple(text), (goal,))


def _spots(chance: Chance, distance: float) -> list[Pose]:
    first = chance.turn()
    angles = [first + at + chance.turn(0.15) for at in _AT]
    lengths = (distance, chance.within(2.3, 2.8), chance.within(2.3, 2.8))
    return [
        Pose.of(d * math.cos(angle), d * math.sin(angle), 0.0, yaw=angle)
        for d, angle in zip(lengths, angles, strict=True)
    ]


def _trapped(chance: Chance, kind: str, at: Pose, height: float, type_: PartType, *, trap: bool) -> list[str]:
    """Returns a storage place with a part that was seen there, perhaps in a trap."""
    lies = Pose.of(*_SUPPORT, height, yaw=chance.turn(0.3))
    if kind == "low shelf":
        return [
            storage("pallet_2", at, height, *_board(chance, height, trap=trap)),
            part("part_2", type_, "pallet_2", lies),
        ]
    if kind == "out of reach":
        side = chance.within(1.2, 1.5) if trap else 0.0
        wide = [box(0.6 + 2.0 * side, 0.8 + 2.0 * side, height, (0.0, 0.0, height / 2.0))] if trap else []
        back = at @ Pose((side, 0.0, 0.0))  # its near edge stays where it is
        return [storage("pallet_2", back, height, *wide), part("part_2", type_, "pallet_2", lies)]
    gap = chance.within(0.38, 0.54) if trap else chance.within(1.3, 1.7)
    return [storage("pallet_2", at, height), part("part_2", type_, "pallet_2", lies), *_room(at, gap)]


def _board(chance: Chance, height: float, *, trap: bool) -> list[Primitive]:
    """Returns a board over all of a place, with a back and sides that carry it."""
    above = height + (chance.within(0.11, 0.16) if trap else chance.within(0.75, 0.95))
    depth = 0.60 if trap else chance.within(0.2, 0.3)
    sides = [box(0.60, 0.02, above - height, (0.0, side * 0.41, (above + height) / 2.0)) for side in (-1.0, 1.0)]
    return [*sides, box(depth, 0.84, 0.02, (0.30 - depth / 2.0, 0.0, above + 0.01))]


def _room(at: Pose, gap: float) -> list[str]:
    """Returns walls around a place, with a gap before it."""
    half, thick, high, front = 1.7, 0.1, 1.2, -2.1
    wing = half - gap / 2.0
    walls = [box(thick, wing, high, (front, side * (gap + wing) / 2.0, high / 2.0)) for side in (-1.0, 1.0)] + [
        box(0.6 - front, thick, high, ((0.6 + front) / 2.0, side * half, high / 2.0)) for side in (-1.0, 1.0)
    ]
    walls.append(box(thick, 2.0 * half, high, (0.6, 0.0, high / 2.0)))
    return [_furniture(f"wall_{number}", at @ block.pose, block) for number, block in enumerate(walls, start=1)]


def _cover(chance: Chance, text: list[str], table: Pose, *, trap: bool) -> str:
    """Returns a block over the compartment: as near above it that no hand gets in, or out of the way."""
    top = next(float(one.split('sk:pose "')[1].split()[2]) for one in text if one.startswith("scene:kit_1 "))
    above = top + (chance.within(0.10, 0.14) if trap else 1.0)
    x, y = -0.05 - 0.073, 0.073  # compartment A; the kit stands 5 cm nearer than the middle of its table
    block = box(0.13, 0.13, 0.30, (x, y, above + 0.15))
    return _furniture("beam", table @ block.pose, block)


def _furniture(name: str, at: Pose, block: Primitive) -> str:
    x, y, z = at.position
    size = ", ".join(f"{length:.4f}" for length in block.size)
    return individual(
        name,
        "kitting:Rack",
        "sk:on scene:floor",
        f'sk:pose "{x:.5f} {y:.5f} {z:.5f} 0 0 {at.yaw:.5f}"^^sk:poseLiteral',
        f"""sk:solid '[{{"kind": "box", "size": [{size}], "at": [0, 0, 0]}}]'^^rdf:JSON""",
    )
