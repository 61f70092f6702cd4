"""The training backend: one worker owns agent, environment and generator.

Commands go in, the newest update comes out; nothing is shared. See `states` for the legal moves.
"""
