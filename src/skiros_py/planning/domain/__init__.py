"""Skills and goals as a planning domain, and how it is written as PDDL."""
