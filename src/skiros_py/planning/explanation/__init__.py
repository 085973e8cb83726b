"""No plan is an answer: why there is none in the operator's words, and the smallest changes that would make one.

Three stages, each run only if the previous one found nothing: facts that never become true even if nothing were ever
undone; goal conditions that exclude each other; a minimal part of the goal for which a planner finds no plan.
"""
