"""The terms of the upper ontology that code speaks of, as CURIEs."""

from __future__ import annotations

from typing import Final

__all__ = [
    "AGENT",
    "ARM",
    "AT",
    "BASE",
    "CAMERA",
    "COMPUTED",
    "CONTAINER",
    "DECK",
    "DEPTH_NOISE",
    "DEVICE",
    "DRIVING_POSE",
    "ELEMENT",
    "FAR",
    "FLOOR",
    "FOOTPRINT",
    "FRAME",
    "FURNITURE",
    "GOAL",
    "GRASP_HEIGHT",
    "GRASP_WIDTH",
    "GRIPPER",
    "HAS_A",
    "HAS_SKILL",
    "HEIGHT",
    "HELD_BY",
    "HOLLOW",
    "HOME",
    "IN",
    "JOINTS",
    "LABEL",
    "LATENCY",
    "LOCATION",
    "MANIPULATABLE",
    "MASS",
    "MAX_ANGULAR",
    "MAX_ANGULAR_ACCELERATION",
    "MAX_FORCE",
    "MAX_GAP",
    "MAX_LINEAR",
    "MAX_LINEAR_ACCELERATION",
    "MISSED_LOOKS",
    "MISSING",
    "MODEL",
    "MOUNTED_ON",
    "NEAR",
    "OBJECT",
    "ON",
    "PLACEMENT",
    "POSE",
    "POSE_FRAME",
    "ROBOT",
    "ROOT",
    "SCENE_CLASS",
    "SIZE",
    "SKILL",
    "SOLID",
    "SPATIAL_THING",
    "START_LOCATION",
    "STATION",
    "STRUCTURE",
    "SUPPORT_HALF_EXTENTS",
    "SUPPORT_OFFSET",
    "SURFACE",
    "TIP",
    "UNKNOWN_LOCATION",
    "VERTICAL_FOV",
    "WIDTH",
]

ELEMENT: Final = "sk:Element"
SPATIAL_THING: Final = "sk:SpatialThing"
AGENT: Final = "sk:Agent"
SKILL: Final = "sk:Skill"
SCENE_CLASS: Final = "sk:Scene"
"""Classes: the top; ``SCENE_CLASS`` is that of the one individual that bears the goals."""

LOCATION: Final = "sk:Location"
ROOT: Final = "sk:Root"
FLOOR: Final = "sk:Floor"
UNKNOWN_LOCATION: Final = "sk:UnknownLocation"
STATION: Final = "sk:Station"
CONTAINER: Final = "sk:Container"
SURFACE: Final = "sk:Surface"
DECK: Final = "sk:Deck"
"""Classes: places. Only a ``ROOT`` is nowhere itself."""

OBJECT: Final = "sk:Object"
MANIPULATABLE: Final = "sk:Manipulatable"
FURNITURE: Final = "sk:Furniture"
"""Classes: physical things."""

ROBOT: Final = "sk:Robot"
DEVICE: Final = "sk:Device"
ARM: Final = "sk:Arm"
BASE: Final = "sk:Base"
GRIPPER: Final = "sk:Gripper"
CAMERA: Final = "sk:Camera"
"""Classes: robots and what they are made of."""

PLACEMENT: Final = "sk:placement"
AT: Final = "sk:at"
IN: Final = "sk:in"
ON: Final = "sk:on"
HELD_BY: Final = "sk:heldBy"
"""Relations: the placement family; an element has one of them."""

STRUCTURE: Final = "sk:structure"
HAS_A: Final = "sk:hasA"
COMPUTED: Final = "sk:computed"
"""Relations: the structure and the computed family."""

HAS_SKILL: Final = "sk:hasSkill"
START_LOCATION: Final = "sk:startLocation"
MOUNTED_ON: Final = "sk:mountedOn"
POSE_FRAME: Final = "sk:poseFrame"
"""Relations: plain ones."""

LABEL: Final = "rdfs:label"
POSE: Final = "sk:pose"
DRIVING_POSE: Final = "sk:drivingPose"
SOLID: Final = "sk:solid"
MASS: Final = "sk:mass"
HOLLOW: Final = "sk:hollow"
SIZE: Final = "sk:size"
SUPPORT_HALF_EXTENTS: Final = "sk:supportHalfExtents"
SUPPORT_OFFSET: Final = "sk:supportOffset"
GRASP_HEIGHT: Final = "sk:graspHeight"
GRASP_WIDTH: Final = "sk:graspWidth"
MISSING: Final = "sk:missing"
MISSED_LOOKS: Final = "sk:missedLooks"
"""Properties: things in space; units are in core.ttl."""

MODEL: Final = "sk:model"
JOINTS: Final = "sk:joints"
TIP: Final = "sk:tip"
HOME: Final = "sk:home"
MAX_GAP: Final = "sk:maxGap"
MAX_FORCE: Final = "sk:maxForce"
FRAME: Final = "sk:frame"
WIDTH: Final = "sk:width"
HEIGHT: Final = "sk:height"
VERTICAL_FOV: Final = "sk:verticalFov"
NEAR: Final = "sk:near"
FAR: Final = "sk:far"
DEPTH_NOISE: Final = "sk:depthNoise"
LATENCY: Final = "sk:latency"
MAX_LINEAR: Final = "sk:maxLinear"
MAX_ANGULAR: Final = "sk:maxAngular"
MAX_LINEAR_ACCELERATION: Final = "sk:maxLinearAcceleration"
MAX_ANGULAR_ACCELERATION: Final = "sk:maxAngularAcceleration"
FOOTPRINT: Final = "sk:footprint"
"""Properties: robot hardware; units are in core.ttl."""

GOAL: Final = "sk:goal"
"""Property of the scene individual: a goal that goes with the scene."""
