"""Generated scenes for ``benchmarks/task_and_motion.py``: five parts that stand close together, and a kit without room.

Fingers get at few of the parts before their neighbours are gone, and into few of the compartments once what is next to
them is full: that follows from shapes alone, no fact of the scene says so.
"""

from __future__ import annotations

import math

from manipulation_scenes import KNOWN, Cell, Chance, PartType, Scene, kit, own_types, part, storage

from skiros_py.geometry import Pose

_NARROW = 0.008, 0.013
"""Distances between parts through which no finger gets [m]."""
_WIDE = 0.036, 0.046
"""Distances between parts through which one does [m]."""
_PLAY = 0.003
"""Play of a part in its compartment, on each side [m]."""
_BETWEEN = 0.024, 0.030
"""Distances between compartments, across which fingers get, but no palm beside what is higher [m]."""
_ROW = 3
"""So many parts stand in a row on the first place, and so many compartments are in the first row of the kit."""
_AWAY = 2.2, 2.7
"""How far from the middle of the robot places stand [m]."""


def packed(seed: int) -> Scene:
    """Returns a scene: three parts in a row on a place, two on another, and five compartments side by side."""
    chance = Chance(seed)
    types = chance.some((*KNOWN, *own_types(chance)), 5)
    first = chance.turn()
    spots = []
    for third in range(3):
        angle, far = first + third * math.tau / 3.0 + chance.turn(0.15), chance.within(*_AWAY)
        spots.append(Pose.of(far * math.cos(angle), far * math.sin(angle), 0.0, yaw=angle))
    heights = [chance.within(0.45, 0.60) for _ in spots]
    text = [storage(f"pallet_{number + 1}", spots[number], heights[number]) for number in range(2)]
    first_of = []
    for place, some in enumerate((types[:_ROW], types[_ROW:]), start=1):
        across = chance.count(0, len(some) - 1)
        text += _in_a_row(chance, some, across, place, heights[place - 1])
        first_of += [(some[across], other) for other in some if other is not some[across]]
    wall = min(0.033, max(0.008, min(one.grasp_height for one in types) - 0.015))
    order = chance.some(types, 5)
    while any((order.index(one) < _ROW) is (order.index(other) < _ROW) for one, other in first_of):
        order = chance.some(types, 5)  # what a narrow gap wants first is in another row than what waits for it
    cells = _compartments(order, chance.within(*_BETWEEN))
    text += kit(spots[2], heights[2], chance.turn(0.2), cells, wall=wall)
    goals = tuple(f"InKit({one.label}, kit_1)" for one in types)
    own = tuple(one for one in types if one.blocks)
    return Scene(f"packed_{seed}", seed, "packed", own, tuple(text), goals)


def _in_a_row(chance: Chance, types: list[PartType], across: int, place: int, height: float) -> list[str]:
    """Returns parts beside each other, from left to right of who stands before the place; one of them lies across."""
    extents = [(one.outline[::-1] if number == across else one.outline) for number, one in enumerate(types)]
    # beside what lies across, whose fingers come from before and behind, it may be narrow: that can be taken first
    beside = [across in (number, number + 1) and chance.count(0, 2) > 0 for number in range(len(types) - 1)]
    gaps = [chance.within(*(_NARROW if narrow else _WIDE)) for narrow in beside]
    y = -(sum(extent[1] for extent in extents) + sum(gaps)) / 2.0
    text = []
    for number, (one, (_, wide)) in enumerate(zip(types, extents, strict=True)):
        turn = (math.pi / 2.0 if number == across else 0.0) + chance.turn(0.03)
        at = Pose.of(-0.07 + chance.within(-0.02, 0.02), y + wide / 2.0, height, yaw=turn)
        text.append(part(f"part_{place}_{number + 1}", one, f"pallet_{place}", at))
        y += wide + (gaps[number] if number < len(gaps) else 0.0)
    return text


def _compartments(types: list[PartType], between: float) -> list[Cell]:
    """Returns a compartment for each part, with just room for it, in two rows."""
    sizes = [tuple(length + 2.0 * _PLAY for length in one.outline) for one in types]
    deep = [max(x for x, _ in row) for row in (sizes[:_ROW], sizes[_ROW:])]
    cells: list[Cell] = []
    for row, some in enumerate((sizes[:_ROW], sizes[_ROW:])):
        x = (-1.0, 1.0)[row] * (deep[row] + between) / 2.0
        y = -(sum(wide for _, wide in some) + between * (len(some) - 1)) / 2.0
        for size in some:
            cells.append(Cell(f"kit_1_{'abcde'[len(cells)]}", x, y + size[1] / 2.0, (size[0], size[1])))
            y += size[1] + between
    return cells
