"""Stands for what scripts of Python 2's time call of `six`, where that is not installed."""

from trajopt.ros.commander.six import moves as moves

PY2, PY3 = False, True
string_types = (str,)
integer_types = (int,)
text_type = str
