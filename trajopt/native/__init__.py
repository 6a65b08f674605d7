"""Native cores: the hot loops of other rooms, compiled. Each has a body in plain Python as its oracle.

| core | room that calls it | what it does |
|---|---|---|
| `proximity` | `query` | kinematics of all samples, and the rows of all pairs that come near |
"""
