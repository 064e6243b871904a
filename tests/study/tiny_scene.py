"""A rope of eight segments that breaks: what takes no time to compute."""

TINY = """
[materials.hooke]
law = "linear"
EA = "1 MN"
[lines.rope]
material = "hooke"
length = "10 m"
segments = 8
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = { held = { pretension = "50 kN", direction = [1, 0, 0] } }
[events.break]
breaks = "rope.end"
time = "40 ms"
[solver]
waves = "plain"
[output]
duration = "4 ms"
every = "2 ms"
quantities = ["position"]
"""
