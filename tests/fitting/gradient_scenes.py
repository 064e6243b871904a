"""Scenes for derivatives: trolleys, ideal cable, floating ship, friction of a bed, rods."""

# cargo with contact and friction on a whole cable, between a post and a winch on a moved ship
TROLLEY = """
gravity = 9.81
[materials.steel]
law = "linear"
EA = "5 MN"
damping = "1 kN s"
[bodies.ship]
position = [5, 0, 0]
motion.surge = { amplitude = 0.2, period = "1.5 s", phase = 0.4 }
points = { post = [0, 0, 0] }
[bodies.cargo]
mass = "1 t"
height = -0.3
on.line = "highline"
on.place = 1.3
on.speed = 1.1
on.stop = 0.4
on.friction = { coefficient = 0.02 }
on.contact = { stiffness = 1e8, damping = "2 kN s/m", depth = 1e-3 }
[lines.highline]
material = "steel"
length = 5
segments = 12
mass = 3
start = { fixed = [0, 0, 0] }
end = { winch = { at = "ship.post", tension = "40 kN", inertia = 20, damping = "200 N s/m" } }
[solver]
waves = "plain"
[output]
duration = "0.4 s"
every = "20 ms"
"""
# cargo on an ideal cable between a post and a ship that floats
FERRY = """
gravity = 9.81
[water]
density = 1025
[materials.steel]
law = "linear"
EA = "57.1 MN"
[bodies.ship]
mass = "400 t"
size = [30, 8, 4]
position = [60, 0, 0.5]
points = { post = [-10, 0, 8] }
hull = { above_keel = 2.2 }
[bodies.ship.control]
stiffness = ["60 kN/m", 0, 0]
damping = ["50 kN s/m", 0, "40 kN s/m"]
turn_damping = [0, "1 MN m s/rad", 0]
[bodies.cargo]
mass = "1 t"
on = { line = "highline", place = 20, speed = 1, stop = 5 }
[lines.highline]
model = "ideal"
material = "steel"
length = 57
segments = 20
mass = 3
diameter = "28 mm"
start = { fixed = [0, 0, 8] }
end = { winch = { at = "ship.post", tension = "80 kN" } }
[measures.h]
height = "cargo"
over = "ship"
level = "6 m"
near = "ship.post"
within = "100 m"
[output]
duration = "3 s"
every = "0.1 s"
"""
# a wire that is pulled over a bed and turned back, so that it sticks and slides
DRAGGED = """
gravity = 9.81
[seabed]
height = 0
stiffness = "1 MPa"
damping = "5 kPa s"
friction = 0.5
[materials.wire]
law = "linear"
EA = "10 MN"
[lines.wire]
material = "wire"
length = 40
segments = 10
mass = 100
start = { fixed = [0, 0, 0] }
end = { motion = { position = [40.02, 0, 0], amplitude = [0.02, 0, 0], period = "3 s", phase = -1.57 } }
[solver]
waves = "plain"
[output]
duration = "2.5 s"
every = "50 ms"
"""
# two rods that fall, the lower one tied to a block that slides on the bed
RODS = """
gravity = 9.81
[seabed]
height = -3
stiffness = "100 kPa"
[materials.stiff]
law = "inextensible"
[lines.upper]
material = "stiff"
length = 1.2
segments = 2
mass = 4
start = "block.ring"
end = { joined = "lower.start", at = [1.46, 0, 0.72] }
[lines.lower]
material = "stiff"
length = 1.5
segments = 2
mass = 3
start = "upper.end"
end = "free"
[bodies.block]
mass = 30
position = [0, 0, 0]
velocity = [1.5, 0, 0]
points = { ring = [0.5, 0, 0] }
free = ["x"]
friction = 0.3
[solver]
step = "2 ms"
[output]
duration = "0.5 s"
every = "20 ms"
"""
