"""What the format allows and what it refuses; each complaint names the place and the rule.

What no key may be, lack or be called is planted in every one in `bad_input/test_mutated_scenes`.
"""

import pytest
from case_loops import each_case
from scene_texts import TEXT, changed, scene
from spincheck.scenarios import EVERYWHERE, ScenarioError, loads

MASS = ("mass = 2.0", "mass = {}")
INERTIA = ("inertia = [1.0, 2.0, 2.5]", "inertia = {}")
ATTITUDE = "euler_zyz_deg = [10.0, 30.0, 20.0]"
OMEGA = "omega_body = [0.5, 1.0, -2.0]"
PIVOT = "[effects.pivot]\n"
PARTICLES = (
    "mass = 2.0\ninertia = [1.0, 2.0, 2.5]\ncom = [0.1, 0.2, 0.3]",
    "particles = [[1, 0, 0, 0], [1, 1, 0, 0], [2, 0, 1, 0]]",
)


def published(*lines):
    return "\n".join(("[[published]]", "tolerance = 1e-6", 'source = "p"', *lines)) + "\n"


def expect(*lines):
    head = ("[[expect]]", 'engine = "e"', 'method = "m"', "timestep = 0.1")
    return "\n".join((*head, *lines)) + "\n"


ALLOWED = {
    "as small as it gets": TEXT,
    "integers for numbers": changed(("mass = 2.0", "mass = 2")),
    "a full tensor": changed(
        (INERTIA[0], "inertia = [[1.4, 0.2, 0.0], [0.2, 1.1, 0.3], [0.0, 0.3, 0.9]]")
    ),
    "a tensor about the origin": changed((INERTIA[0], INERTIA[0] + '\ninertia_about = "origin"')),
    "point masses": changed(PARTICLES),
    "point masses on a pivot": changed(PARTICLES, more=PIVOT),
    "quaternion and omega_world": changed(
        (ATTITUDE, "quaternion_wxyz = [1, 0, 0, 0]"), (OMEGA, "omega_world = [1, 2, 3]")
    ),
    "a quaternion of a few digits": changed((ATTITUDE, "quaternion_wxyz = [0.96, 0, 0.28, 0]")),
    "rotation vector": changed((ATTITUDE, "rotation_vector_deg = [0, 90, 0]")),
    "rates": changed((OMEGA, "euler_zyz_rates = [1, 2, 3]")),
    "thrown": changed((OMEGA, f"{OMEGA}\nposition = [1, 2, 3]\nvelocity = [4, 5, 6]")),
    "every effect": changed(
        more="[effects.gravity]\nacceleration = [0, 0, -9.81]\n[effects.pivot]\n"
        "[effects.drag]\nrotational = 0.1\n[effects.torque]\nbody = [0, 0, 1]\n"
    ),
    "effects in one line": changed(("[body]", "effects = { pivot = {} }\n[body]")),
    "published": changed(more=published("t = 1.0", "energy = 2.0")),
    "expected bounds": changed(more=expect("omega = 1e-6")),
    "expected blow-up": changed(more=expect('outcome = "diverges"')),
}


@each_case("text", ALLOWED)
def test_it_is_a_scene(text):
    assert loads(text, name="made").title == "t"


REFUSED = {
    # numbers
    "negative": ((MASS[0], "mass = -2"), r":5: \[body\] mass: .* greater than 0, got -2"),
    "huge": (
        (MASS[0], f"mass = 1{400 * '0'}"),
        r":5: \[body\] mass: is too large for a double, got 1000",
    ),
    "no digest": (
        (MASS[0], f'{MASS[0]}\nsha256 = "zz"'),
        r"sha256: must be a SHA-256, 64 hexadecimal digits, got 'zz'",
    ),
    "no duration": (("duration = 1.0", "duration = 0"), r"\[window\] duration: .* greater than 0"),
    "one sample": (
        ("samples = 5", "samples = 1"),
        r":13: \[window\] samples: .* equal to 2, got 1",
    ),
    "too many": (("samples = 5", "samples = 1_000_001"), r"samples: .* equal to 1000000, got"),
    "half a sample": (("samples = 5", "samples = 5.5"), r"samples: .* whole number, got 5\.5"),
    # shapes
    "one moment": ((INERTIA[0], "inertia = 1.0"), r":6: \[body\] inertia: must be an array, got 1"),
    "decimal commas": (
        (ATTITUDE, "euler_zyz_deg = [0,0, 30,0, 0,0]"),
        r":9: \[start\] euler_zyz_deg: must have 3 entries, got 6: \[0, 0, 30, 0, 0, 0\]",
    ),
    # keys
    "another version": (("spincheck = 1", "spincheck = 2"), r":1: spincheck: .* be 1, got 2"),
    # the body
    "lopsided matrix": (
        (INERTIA[0], "inertia = [[2, 0, 0.1], [0, 2, 0], [0, 0, 2]]"),
        r":6: \[body\] inertia: must be a symmetric matrix, got 0.1 in row 1, column 3, and 0 in",
    ),
    "no such body": (
        (INERTIA[0], "inertia = [1, 2, 4]"),
        r":6: \[body\] inertia: no principal moment .* 1, 2, 4",
    ),
    "no mass": ((MASS[0], ""), r":4: \[body\]: missing 'mass'; or give 'particles'"),
    "both kinds of body": (
        (MASS[0], "particles = [[1, 0, 0, 0], [1, 1, 0, 0], [1, 0, 1, 0]]"),
        r"\[body\]: 'particles' replaces mass, com and inertia; remove 'com', 'inertia'",
    ),
    "two particles": (
        (PARTICLES[0], "particles = [[1, 0, 0, 0], [1, 1, 0, 0]]"),
        r":5: \[body\] particles: must have at least 3 entries",
    ),
    "particles in a line": (
        (PARTICLES[0], "particles = [[1, 0, 0, 0], [1, 1, 0, 0], [1, 2, 0, 0]]"),
        r":5: \[body\] particles: principal moments about the com must be positive, got 0, 2, 2",
    ),
    # the start
    "no angular velocity": (
        (OMEGA, ""),
        r"\[start\]: angular velocity takes exactly one .* got none; an example: omega_body = \[",
    ),
    "rates without angles": (
        (f"{ATTITUDE}\n{OMEGA}", "rotation_vector_deg = [0, 0, 0]\neuler_zyz_rates = [1, 2, 3]"),
        r"'euler_zyz_rates' needs the attitude as 'euler_zyz_deg'",
    ),
}


@each_case(("replacement", "complaint"), REFUSED)
def test_it_is_refused(replacement, complaint):
    with pytest.raises(ScenarioError, match=complaint):
        scene(replacement)


def rotor(line: str) -> str:
    """A table of a rotor, one of its lines another."""
    lines = {
        "axis": "axis = [0.0, 0.0, 2.0]",
        "position": "position = [0.0, 0.1, 0.0]",
        "mass": "mass = 0.5",
        "inertia": "inertia = [1.0, 1.0]",
        "spin": "spin = 3.0",
        "hinge": 'hinge = "free"',
    }
    lines[line.split(" ")[0]] = line
    return "\n".join(["[[rotors]]", *lines.values()]) + "\n"


REFUSED_TABLES = {
    "an effect outside effects": (
        "[gravity]\nacceleration = [0, 0, -9.81]\n",
        r":14: gravity: unknown key; did you mean '\[effects.gravity\]'\?$",
    ),
    "misspelt effects": (
        "[effect.gravity]\nacceleration = [0, 0, -9.81]\n",
        r":14: effect: unknown key; did you mean 'effects'\?",
    ),
    "unknown effect": (
        "[effects.wind]\n",
        r"\[effects\] wind: unknown key; known keys: drag, gravity",
    ),
    "a key where there is none": (
        "[effects.pivot]\nat = 1\n",
        r":15: \[effects.pivot\] at: unknown key; known keys: none$",
    ),
    "no drag": (
        "[effects.drag]\nrotational = 0.0\n",
        r"\[effects.drag\] rotational: .* greater th",
    ),
    "no torque": ("[effects.torque]\n", r"torque: takes exactly one of 'body' and 'world'"),
    "two torques": (
        "[effects.torque]\nbody = [0, 0, 1]\nworld = [0, 0, 1]\n",
        r"torque: takes exactly one of 'body' and 'world'",
    ),
    "a rotor of negative mass": (
        rotor("mass = -1.0"),
        r":17: \[\[rotors\]\] number 1 mass: .* greater than 0, got -1",
    ),
    "too many rotors": (
        17 * rotor("spin = 3.0"),
        r":14: rotors: must have at most 16 entries, got 17",
    ),
    "an axis of no length": (
        rotor("axis = [0.0, 0.0, 0.0]"),
        r":15: \[\[rotors\]\] number 1 axis: must have a length, got \[0, 0, 0\]",
    ),
    "a rotor that is no body": (
        rotor("inertia = [1.0, 2.5]"),
        r":18: .* inertia: the moment along .* twice that across it, got 1, 2.5 kg m²",
    ),
    "a locked rotor that spins": (
        rotor('hinge = "locked"'),
        r":19: .* number 1 spin: must be 0 on a locked hinge, got 3 rad/s",
    ),
    "a second rotor on no hinge": (
        rotor("mass = 1.0") + rotor('hinge = "loose"'),
        r":27: \[\[rotors\]\] number 2 hinge: .* 'free', 'driven' or 'locked', got 'loose'",
    ),
    "a body that is none once its rotors are in": (
        rotor("position = [0.0, 0.0, 1e200]"),
        r":14: \[\[rotors\]\] number 1: with it in the body, mass, com and inertia are too large",
    ),
    "a rotor too far to be computed with": (
        rotor("spin = 1e160"),
        r":14: \[\[rotors\]\] number 1: the rotor's angular momentum is 1.0e\+160 .* too large",
    ),
    "published after the end": (
        published("t = 1.5", "energy = 2.0"),
        r":17: \[\[published\]\] number 1 t: must lie in the window, got 1.5 s of 1 s",
    ),
    "published nothing": (published("t = 0.5"), r"\[\[published\]\] number 1: names no value"),
    "second published value": (
        published("t = 0.5", "energy = 2.0") + published("t = 0.5", 'energy = "x"'),
        r":23: \[\[published\]\] number 2 energy: .* number, got 'x'",
    ),
    "expected nothing": (expect(), r"\[\[expect\]\] number 1: takes bounds .*, or 'outcome'"),
    "bounds on a blow-up": (
        expect("omega = 1.0", 'outcome = "diverges"'),
        r"\[\[expect\]\] number 1: takes bounds .*, or 'outcome'",
    ),
    "a bound on what the scene lacks": (
        expect("spins = 1e-3"),
        r":18: \[\[expect\]\] number 1 spins: the scene has no spins of the rotors",
    ),
    "another outcome": (
        expect('outcome = "ok"'),
        r"\[\[expect\]\] number 1 outcome: .* 'diverges'",
    ),
}


@each_case(("more", "complaint"), REFUSED_TABLES)
def test_a_table_is_refused(more, complaint):
    with pytest.raises(ScenarioError, match=complaint):
        scene(more=more)


def test_a_matrix_that_is_symmetric_but_for_rounding_is_symmetric():
    text = "inertia = [[2, 0, 0.10000000000000002], [0, 2, 0], [0.1, 0, 2]]"
    tensor = scene((INERTIA[0], text)).body.inertia_com
    assert (tensor == tensor.T).all()


def test_a_key_has_one_complaint_but_each_table_of_its_own():
    with pytest.raises(ScenarioError) as raised:
        scene(("title =", "rotors = [1, 2]\ntitle ="), ("[0.1, 0.2, 0.3]", '["x", "y", 0.3]'))
    about = [line.partition(": ")[2] for line in str(raised.value).splitlines()]
    complained_of = ["[body] com[0]", "[[rotors]] number 1", "[[rotors]] number 2"]
    assert [words.partition(": must")[0] for words in about] == complained_of


def test_a_pivot_needs_to_know_where_the_com_is():
    with pytest.raises(ScenarioError, match=r":4: \[body\]: needs 'com' with a pivot"):
        scene(("com = [0.1, 0.2, 0.3]\n", ""), more=PIVOT)


@each_case("key", ["position", "velocity"])
def test_a_body_on_a_pivot_has_no_flight(key):
    with pytest.raises(
        ScenarioError, match=rf":11: \[start\] {key}: for free bodies; this one has"
    ):
        scene((OMEGA, f"{OMEGA}\n{key} = [0, 0, 1]"), more=PIVOT)


def test_every_complaint_is_reported_at_once():
    with pytest.raises(ScenarioError) as complaint:
        scene(
            (MASS[0], "mass = -1"), ("samples = 5", "samples = 1"), (OMEGA, "omega_body = [0, 0]")
        )
    assert [line.split(":")[1] for line in str(complaint.value).splitlines()] == ["5", "10", "13"]


@each_case("text", ALLOWED)
def test_a_document_cannot_be_changed(text):
    document = loads(text, name="made").document
    with pytest.raises(ValueError, match="frozen"):
        document.title = "another"


def test_expected_bounds_are_those_given_of_any_signals():
    bounds = {name: 1e-6 * k for k, name in enumerate(EVERYWHERE, start=1)}
    (expectation,) = scene(
        more=expect(*(f"{name} = {bound}" for name, bound in bounds.items()))
    ).expect
    assert expectation.bounds() == bounds
    (expectation,) = scene(more=expect("omega = 1e-6", "velocity = 1e-8")).expect
    assert expectation.bounds() == {"omega": 1e-6, "velocity": 1e-8}


def test_published_values_are_those_given():
    (value,) = scene(
        more=published("t = 0.5", "energy = 2", "L_world = [1, 2, 3]")
    ).document.published
    assert value.values() == {"energy": 2.0, "L_world": (1.0, 2.0, 3.0)}
