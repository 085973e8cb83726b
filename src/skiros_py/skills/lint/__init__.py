"""Rules for plug-ins: what is wrong with a skill, a primitive or a condition, before it is offered to anybody."""
