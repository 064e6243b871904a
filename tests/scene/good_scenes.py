"""Scenes that are right: the tests read them, and spoil copies of them."""

# One line under water that parts, with everything written on its own line.
ROPE = """\
title = "A rope"
gravity = "9.81 m/s2"

[water]
density = "1025 kg/m3"

[materials.nylon]
law = "tanh"
p1 = "270.3 kN"
p2 = 10.2
p3 = -2.128
p4 = "262.7 kN"
p5 = "135.5 N"

[lines.rope]
material = "nylon"
length = "60 m"
segments = 200
mass = "2.238 kg/m"
diameter = "50 mm"
drag = { normal = 1.5, tangential = 0.01 }
start = { fixed = [0, 0, 0] }
end = { held = { pretension = "45 kN", direction = [1, 0, 0] } }

[events.break]
breaks = "rope.end"
time = "5 ms"

[sweep]
"lines.rope.end.held.pretension" = ["45 kN", "180 kN"]

[solver]
method = "leapfrog"

[output]
duration = "200 ms"
every = "1 ms"

[references.paper]
source = "nobody"
values = { static_strain = [0.1, nan] }
"""

# Two lines, a body, every kind of end and material, files beside the scene.
BRIDLE = """\
[air]
density = 1.2
current = { profile = "power", velocity = ["10 kn", 0, 0], exponent = 0.14, depth = "30 m" }

[materials.steel]
law = "linear"
EA = "20 MN"
damping = "2 kN s"

[materials.fibre]
law = "polynomial"
coefficients = ["1 MN", "2 MN"]
max_strain = "20 %"

[materials.tested]
law = "table"
file = "tested.csv"

[lines.upper]
material = "steel"
length = 40
segments = 20
grading = 2.5
mass = 3.0
start = { motion = { position = [0, 0, 10], amplitude = [0, 0, "1 m"], period = "8 s" } }
end = "bob"

[lines.lower]
material = "fibre"
length = "10 m"
segment_lengths = ["4 m", 3, 3]
mass = 1
diameter = "30 mm"
drag = { normal = 1.2, tangential = 0.01 }
bending = { EI = "10 N m2" }
start = "bob"
end = "tail.start"

[lines.tail]
material = "tested"
length = "500 cm"
segments = 5
mass = 1
start = "lower.end"
end = { motion = { file = "tail.csv" } }

[bodies.bob]
mass = "0.5 t"
position = [30, 0, 0]
volume = "0.1 m3"

[events.cut]
breaks = "upper@37.5 m"
time = 0

[events.slip]
breaks = "lower.start"
time = "1 s"
start = "2 s"

[solver]
method = "tsit5"
rtol = 1e-6
atol = 1e-8
max_steps = 100000
dtype = "float32"

[statics]
tolerance = 1e-9

[output]
duration = "1 min"
every = 0.1
quantities = ["position", "tension"]
"""

TESTED_CSV = "# a tensile test\nstrain, tension\n0, 0\n0.1, 20e3\n0.2, 80e3\n"
TAIL_CSV = "t,x,y,z\n0,45,0,0\n1,45,0,1\n60,45,1,1\n"
FILES = {"tested.csv": TESTED_CSV, "tail.csv": TAIL_CSV}


def short_runs(duration, pretensions, more=""):
    """ROPE of twelve segments, with other pretensions (TOML) for so long, and `more` in its [output]."""
    return (
        ROPE.partition("[references.paper]")[0]
        .replace("segments = 200", "segments = 12")
        .replace('"200 ms"', f'"{duration}"')
        .replace('every = "1 ms"', f'every = "1 ms"{more}')
        .replace('["45 kN", "180 kN"]', pretensions)
    )


def write(folder, text, files=FILES):
    """Write a scene and the files it names into a folder; return the scene's path."""
    for name, content in files.items():
        (folder / name).write_text(content)
    path = folder / "scene.toml"
    path.write_text(text)
    return path
