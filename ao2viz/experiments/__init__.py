"""Experiments: what is trained, where, and what came out, over seeds and settings."""
