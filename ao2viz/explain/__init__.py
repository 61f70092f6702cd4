"""Words and exports computed from recorded decisions; nothing here asks the agent again."""
