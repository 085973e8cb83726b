"""The world model: the ontology says what can be, the scene what is; every change is checked, dated and explained."""
