"""One agent, one `.ao2` file: a zip of plain arrays and a versioned manifest; no pickle.

`docs/format.md` specifies it. Rule: whatever is wrong with a file becomes an `AgentFileError`.
"""
