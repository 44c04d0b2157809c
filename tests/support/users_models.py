"""Users' models in a few lines."""

from pathlib import Path

#: A tensor with three distinct moments, and products of inertia.
TENSOR = 'ixx="0.03" ixy="0.001" ixz="0" iyy="0.04" iyz="0" izz="0.05"'


def inertial(mass="2", tensor=TENSOR, origin='<origin xyz="0.1 0 0" rpy="0 0 0.5"/>'):
    return f'<inertial>{origin}<mass value="{mass}"/><inertia {tensor}/></inertial>'


def diagonal(*moments):
    keys = zip(("ixx", "iyy", "izz"), moments, strict=True)
    return " ".join([f'{key}="{moment}"' for key, moment in keys] + ['ixy="0" ixz="0" iyz="0"'])


def link(name, inside=""):
    return f'<link name="{name}">{inside}</link>\n'


def joint(parent, child, kind="continuous", origin='<origin xyz="0 0 1" rpy="0 0.3 0"/>'):
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="to-{child}" type="{kind}">{ends}{origin}<axis xyz="0 0 1"/></joint>\n'


def robot(*parts, head=""):
    return f'{head}<robot name="made-up">\n{"".join(parts)}</robot>\n'


def arm(tensor=TENSOR, mass="2", inside=""):
    """A base without an inertia, and an arm that turns on it."""
    return robot(link("base"), link("arm", inertial(mass, tensor) + inside), joint("base", "arm"))


def body(inside, after=""):
    return f'<mujoco>{after}<worldbody><body name="arm">{inside}</body></worldbody></mujoco>'


def written(folder: Path, text: str, name: str = "robot.urdf") -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def arm_with_a_tool(tensor=TENSOR) -> str:
    """A robot whose tool no joint moves, so that readers fuse it with the arm."""
    return robot(
        link("base"),
        link("arm", inertial(tensor=tensor)),
        link("tool", inertial(tensor=tensor)),
        joint("base", "arm"),
        joint("arm", "tool", "fixed"),
    )
