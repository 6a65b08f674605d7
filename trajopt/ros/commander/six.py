"""Stand-in for the part of `six` that scripts from Python 2 use, if `six` is not installed."""

import builtins
import sys
from types import ModuleType

PY2, PY3 = False, True
string_types = (str,)
integer_types = (int,)
text_type = str
moves = ModuleType(f"{__name__}.moves", "Stand-in for `six.moves`: Python 3's own names.")
vars(moves).update({name: vars(builtins)[name] for name in ("input", "range", "zip", "map", "filter")})
sys.modules[moves.__name__] = moves
