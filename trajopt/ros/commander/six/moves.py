"""Stand-in for `six.moves`: Python 3's own names."""

import builtins

input = builtins.input
range = builtins.range
zip = builtins.zip
map = builtins.map
filter = builtins.filter
