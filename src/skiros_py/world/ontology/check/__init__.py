"""Checks ontology files: their declarations, and whether they are consistent."""

from skiros_py.world.ontology.check.checking import CheckReport, ReasonerChoice, check_ontology
from skiros_py.world.ontology.check.material import Finding, FindingKind, Severity

__all__ = ["CheckReport", "Finding", "FindingKind", "ReasonerChoice", "Severity", "check_ontology"]
