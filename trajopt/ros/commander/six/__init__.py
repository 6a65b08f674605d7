"""Stand-in for the part of `six` that scripts from Python 2 use, if `six` is not installed."""

from trajopt.ros.commander.six import moves as moves

PY2, PY3 = False, True
string_types = (str,)
integer_types = (int,)
text_type = str
