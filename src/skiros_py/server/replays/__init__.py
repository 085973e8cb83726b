"""What jobs looked like: kept while they run, shown again afterwards."""
