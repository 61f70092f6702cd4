"""Gymnasium environments as tasks an AO2 agent can take on, with names, units and settings."""
