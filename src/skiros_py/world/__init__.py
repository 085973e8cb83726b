"""The world model: the ontology defines the concepts, the scene the current state; changes are validated and logged."""
