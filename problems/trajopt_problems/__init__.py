"""Problems: each module defines small functions that return a `trajopt.Problem`.

Any package can add problems by the entry-point group `trajopt.problems`: a name, and a function that
takes no argument it cannot default and returns a problem. One that takes an argument `rng` has random
instances too, drawn until start and goal are clear of everything; one marked by `trajopt.refused`
has no solution. `trajopt suite` plans them all.

A way to the goal is known for the fixed instances only: of a random one, start and goal are known to be
feasible, and the openings between them are as wide as those of the fixed one within a few
centimetres.

Not here, because no requirement can say it yet: following a line or a figure, at constant speed or at
all, and the mass of what is carried.
"""
