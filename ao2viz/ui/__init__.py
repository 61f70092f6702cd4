"""The dashboard: one loop that owns the screen, fed by commands and frozen updates."""
