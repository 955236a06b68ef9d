"""Scores of detectors, offline and in the loop, and the report; import from the modules."""
