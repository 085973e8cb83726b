"""From world, skills and goal to a plan that was replayed, or to the reasons why there is none."""
