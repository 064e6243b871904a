"""Short names of numbers of a scene, for axes and tables."""

from lumpedcable.scene.motions import FREEDOMS
from lumpedcable.scene.tree import Spot, is_open_list, spot_at
from lumpedcable.scene.validate import SECTIONS

__all__ = ["label_of"]


def label_of(root: Spot, key: str) -> str:
    """Return "rope pretension" for lines.rope.end.held.pretension, "rope fixed z" for ... .2.

    Of a freedom of a ship "receiver heave period", of what relaxes in a material "nylon fast time".
    """
    words = key.split(".")
    vector = spot_at(root, tuple(words[:-1]))
    if vector is not None and isinstance(vector.value, list):
        component = words[-1] if is_open_list(vector) else "xyz"[int(words[-1])]
        # one of a list of vectors is told with the list's name: "velocity 3 x"
        of = -3 if words[-2].isdecimal() else -2
        words[of:] = [" ".join((*words[of:-1], component))]
    branch = words[0] == "materials" and words[2:3] == ["relaxation"] and len(words) > 4
    if len(words) > 2 and (words[-2] in FREEDOMS or branch):
        words[-2:] = [f"{words[-2]} {words[-1]}"]
    return f"{words[1]} {words[-1]}" if words[0] in SECTIONS and len(words) > 2 else words[-1]
