"""The paper's experiments, run side by side, and the report of what came out."""
