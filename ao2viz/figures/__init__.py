"""Data in, plotly figures out; no viewer, no state."""
