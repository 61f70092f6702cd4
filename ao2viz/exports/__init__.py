"""What leaves ao2viz: an agent and its recorded decisions in formats that others read.

Rule: an export formats what was recorded. Only a format whose purpose it is (rules, pictures of
the environment) asks the agent or the environment again, and says so.
"""
