"""What authors write: parameters, conditions, skills, primitives; and what they may reach from there."""
