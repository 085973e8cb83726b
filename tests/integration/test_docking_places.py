"""Planners know no distances: of docking places that are alike, plans take those that make for less driving."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.planning.plan import Plan
from skiros_py.station.session import Options, Session

SCENE = Path(__file__).parents[2] / "scenes" / "kitting_two.ttl"
GOALS = [f"ObjectAtLocation({part}_2, kit_2_{slot})" for part, slot in (("starter", "a"), ("compressor", "c"))]


def sides(scene: Path) -> dict[str, set[str]]:
    """Returns the docking places that each robot drives to."""
    with Session(str(scene), Options(fake=True)) as session:
        outcome = session.plan([*session.goal, *session.parse(GOALS)]).outcome
    assert isinstance(outcome, Plan)
    rides = [(s.arguments["Robot"], s.arguments["Location"]) for s in outcome.steps if s.skill == "drive"]
    return {robot: {place for who, place in rides if who == robot and "kit" in place} for robot, _ in rides}


@pytest.mark.parametrize("names", [("north", "south"), ("south", "north")])
def test_robots_keep_to_their_side_regardless_of_the_names_of_docking_places(
    tmp_path: Path, names: tuple[str, str]
) -> None:
    scene = tmp_path / "two.ttl"
    text = SCENE.read_text().replace("_north", "_*").replace("_south", f"_{names[1]}").replace("_*", f"_{names[0]}")
    scene.write_text(text)
    north, south = ({f"kit_{kit}_{name}" for kit in (1, 2)} for name in names)

    found = sides(scene)

    assert found["robot_1"] <= north
    assert found["robot_2"] <= south
