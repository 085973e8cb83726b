"""Generates packages and their contents: from a few options of the author to working, tested code."""

from skiros_py.scaffold.condition import NewCondition, draft_condition
from skiros_py.scaffold.draft import Draft
from skiros_py.scaffold.ontology import NewOntology, draft_ontology
from skiros_py.scaffold.package import NewPackage, draft_package
from skiros_py.scaffold.primitive import NewPrimitive, draft_primitive
from skiros_py.scaffold.project import Knowledge, Project, knowledge_of
from skiros_py.scaffold.robot import NewRobot, draft_robot
from skiros_py.scaffold.scene import NewScene, draft_scene
from skiros_py.scaffold.skill import NewSkill, draft_skill

__all__ = [
    "Draft",
    "Knowledge",
    "NewCondition",
    "NewOntology",
    "NewPackage",
    "NewPrimitive",
    "NewRobot",
    "NewScene",
    "NewSkill",
    "Project",
    "draft_condition",
    "draft_ontology",
    "draft_package",
    "draft_primitive",
    "draft_robot",
    "draft_scene",
    "draft_skill",
    "knowledge_of",
]
