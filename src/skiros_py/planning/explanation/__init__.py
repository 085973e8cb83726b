"""No plan is an answer: why there is none in the operator's words, and the smallest changes that would make one.

Three stages, each asked only where the one before found nothing: what never becomes true even if nothing were ever
undone; what in the goal excludes each other; a smallest part of the goal that a planner finds no plan for.
"""

from skiros_py.planning.explanation.causes import certain_causes, find_causes
from skiros_py.planning.explanation.explaining import Explanation, explain
from skiros_py.planning.explanation.repairs import Solve
from skiros_py.planning.explanation.trial import Trial

__all__ = ["Explanation", "Solve", "Trial", "certain_causes", "explain", "find_causes"]
