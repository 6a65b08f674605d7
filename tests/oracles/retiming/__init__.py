"""Retiming in plain Python: what the core `timing` does, step by step, with SciPy's splines."""
