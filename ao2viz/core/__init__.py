"""The agent itself: a forest of options, how it is searched, grown, taught and asked.

Rule: this folder knows numpy and numba only. It prints nothing, reads no clock, draws no global
random numbers and touches no file; what it decides, it returns.
"""
