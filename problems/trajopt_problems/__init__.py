"""Problems: each module defines small functions that return a `trajopt.Problem`.

Any package can add problems by the entry-point group `trajopt.problems`: a name, and a function that
takes no argument it cannot default and returns a problem.
"""
