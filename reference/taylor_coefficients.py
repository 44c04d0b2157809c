"""Taylor coefficients of a top's motion about one instant, order by order.

With ' the time derivative, moments I, ℓ = M r_com, and Γ, Σ the gravity and the torque that are
constant in the world as seen from the principal axes::

    I ω' = (I ω + h) × ω + ℓ × Γ + torque_axes + Σ − c ω   Euler, h the rotors' constant momentum
    q'   = ½ q ⊗ (0, ω)                                    q takes axes to world
    Γ'   = Γ × ω,  Σ' = Σ × ω                              Poisson: a fixed vector, seen turning

On a table (scenarios/effects/table.py) with normal force N, the tip at a from the centre of mass, U
the upward normal as seen from the axes, b = a × U, u the ω' of Euler's equation above, e = (m/I) b,
and f = N/m::

    U' = U × ω,  ω' = u + f e,  f (1 + b·e) = −g_z − a·(U' × ω) − b·u

(Goldstein, Poole & Safko, Classical Mechanics, 3rd ed., §5.5, and §4.9 for vectors seen turning.)
Right-hand sides are sums of products of two series, so that order n + 1 follows from orders 0..n
by Cauchy products (Jorba & Zou, Experimental Mathematics 14 (2005) 99-117, section 2.1), and f as
a quotient. Γ, Σ and U are not part of the state, because rounding would make them inconsistent with
q: every step computes them from q, and only their higher orders from Poisson's equation.

A series is an array with a row for each order and a column for each component.
"""

from typing import NamedTuple

from .kernel import kernel
from .taylor_numbers import (
    Number,
    Table,
    add,
    add_product,
    load,
    multiply,
    negative,
    reciprocal,
    rounded,
    store,
    zero,
)

Vector = tuple[Number, Number, Number]

# Columns of a series. The first STATE are the state.
OMEGA, Q, STATE, GRAVITY, TORQUE, UP = 0, 3, 7, 7, 10, 13
# On a table: U', b, e, u; 1 + b·e and f.
UP_RATE, ARM, GAIN, OTHER, MOBILITY, PRESSED, COLUMNS = 16, 19, 22, 25, 28, 29, 30

# Rows of the table of constants. Each has a column for each axis; "and cyclic" means that those of
# the other two axes follow by cyclic permutation.
EULER = 0  # (I₂ − I₃)/I₁ and cyclic
LEVER_NEXT = 1  # ℓ₂/I₁ and cyclic, 1/m
LEVER_AFTER = 2  # −ℓ₃/I₁ and cyclic, 1/m
CONSTANT = 3  # torque_axes/I, rad/s²
INVERSE_MOMENT = 4  # 1/I, 1/(kg m²)
LINEAR = 5  # −c/I, 1/s
GRAVITY_WORLD = 6  # m/s²
TORQUE_WORLD = 7  # N m
TIP = 8  # a, m
MASS_OVER_MOMENT = 9  # m/I, 1/m²
UP_WORLD = 10
DOWN_AND_RADIUS = 11  # −g_z, m/s²; radius of the tip, m; 1 if lift-off ends the motion, else 0
MOMENTUM = 12  # h, kg m²/s
ROWS = 13

# The rows of the constants, and the columns of the series, that hold the vectors fixed in the
# world.
WORLD_CONSTANTS = (GRAVITY_WORLD, TORQUE_WORLD, UP_WORLD)
WORLD_VECTORS = (GRAVITY, TORQUE, UP)
#: Index, among these vectors, of the one that only a table has.
ON_TABLE = 2

# a × b has component i = a[NEXT[i]] b[AFTER[i]] − a[AFTER[i]] b[NEXT[i]].
NEXT = (1, 2, 0)
AFTER = (2, 0, 1)


class Terms(NamedTuple):
    """Which terms the equations of a motion have; other terms are not computed.

    `world_vectors` says whether there is gravity, a torque constant in the world, and a table, in
    this order; `linear` whether there is a torque −c ω; `momentum` whether there is h × ω.
    """

    world_vectors: tuple[bool, bool, bool]
    linear: bool
    momentum: bool


@kernel
def _vector(series: Table, n: int, column: int) -> Vector:
    """Return the n-th Taylor coefficient of the vector in the three columns from `column` on."""
    return load(series, n, column), load(series, n, column + 1), load(series, n, column + 2)


@kernel
def _omega_products(series: Table, n: int) -> Vector:
    """Return the n-th Taylor coefficients of ω₂ω₃, ω₃ω₁, ω₁ω₂, given the `series` of ω."""
    a = b = c = zero(series)
    for k in range(n + 1):
        w1, w2, w3 = _vector(series, k, OMEGA)
        v1, v2, v3 = _vector(series, n - k, OMEGA)
        a = add_product(a, w2, v3)
        b = add_product(b, w3, v1)
        c = add_product(c, w1, v2)
    return rounded(a), rounded(b), rounded(c)


@kernel
def _q_times_omega(series: Table, n: int) -> tuple[Number, Number, Number, Number]:
    """Return the n-th Taylor coefficients of the quaternion product q ⊗ (0, ω).

    `series` has the coefficients of q and ω.
    """
    r = a = b = c = zero(series)
    for k in range(n + 1):
        w1, w2, w3 = _vector(series, k, OMEGA)
        q0 = load(series, n - k, Q)
        q1, q2, q3 = _vector(series, n - k, Q + 1)
        p1, p2, p3 = negative(q1), negative(q2), negative(q3)
        r = add_product(add_product(add_product(r, p1, w1), p2, w2), p3, w3)
        a = add_product(add_product(add_product(a, q0, w1), q2, w3), p3, w2)
        b = add_product(add_product(add_product(b, q0, w2), q3, w1), p1, w3)
        c = add_product(add_product(add_product(c, q0, w3), q1, w2), p2, w1)
    return rounded(r), rounded(a), rounded(b), rounded(c)


@kernel
def cross_omega(series: Table, column: int, n: int) -> Vector:
    """Return the n-th Taylor coefficient of v × ω, given the `series` of both vectors.

    v is in the three columns from `column` on.
    """
    a = b = c = zero(series)
    for k in range(n + 1):
        w1, w2, w3 = _vector(series, k, OMEGA)
        v1, v2, v3 = _vector(series, n - k, column)
        a = add_product(add_product(a, v2, w3), negative(v3), w2)
        b = add_product(add_product(b, v3, w1), negative(v1), w3)
        c = add_product(add_product(c, v1, w2), negative(v2), w1)
    return rounded(a), rounded(b), rounded(c)


@kernel
def _acceleration(
    series: Table, constants: Table, terms: Terms, n: int, i: int, product: Number
) -> Number:
    """Return the n-th Taylor coefficient of component i of ω', without the force of a table.

    `product` is the n-th coefficient of the product of the other two components of ω. `series` has
    the n-th coefficients of ω and of the vectors fixed in the world; `constants` and `terms` are
    those of the equations of motion.
    """
    total = multiply(load(constants, EULER, i), product)
    if terms.world_vectors[0]:
        after, next_ = load(series, n, GRAVITY + AFTER[i]), load(series, n, GRAVITY + NEXT[i])
        total = add_product(total, load(constants, LEVER_NEXT, i), after)
        total = add_product(total, load(constants, LEVER_AFTER, i), next_)
    if terms.world_vectors[1]:
        torque = load(series, n, TORQUE + i)
        total = add_product(total, load(constants, INVERSE_MOMENT, i), torque)
    if terms.linear:
        total = add_product(total, load(constants, LINEAR, i), load(series, n, OMEGA + i))
    if terms.momentum:
        gyroscopic = multiply(load(constants, MOMENTUM, NEXT[i]), load(series, n, OMEGA + AFTER[i]))
        gyroscopic = add_product(
            gyroscopic,
            negative(load(constants, MOMENTUM, AFTER[i])),
            load(series, n, OMEGA + NEXT[i]),
        )
        total = add_product(total, load(constants, INVERSE_MOMENT, i), rounded(gyroscopic))
    if n == 0:
        total = add(total, load(constants, CONSTANT, i))
    return rounded(total)


@kernel
def _turn_world_vector(series: Table, inverses: Table, n: int, column: int) -> None:
    rate = cross_omega(series, column, n)
    for i in range(3):
        store(series, n + 1, column + i, multiply(load(inverses, 0, n + 1), rate[i]))


@kernel
def _dot(series: Table, n: int, left: int, right: int) -> Number:
    """Return the n-th Taylor coefficient of u · v.

    u and v are in the three columns of `series` from `left` on and from `right` on.
    """
    total = zero(series)
    for k in range(n + 1):
        u1, u2, u3 = _vector(series, k, left)
        v1, v2, v3 = _vector(series, n - k, right)
        total = add_product(add_product(add_product(total, u1, v1), u2, v2), u3, v3)
    return rounded(total)


@kernel
def _press(series: Table, constants: Table, n: int) -> None:
    """Write the n-th Taylor coefficients of f = N/m, and of all series that f depends on.

    N is the normal force of the plane that the body's tip slides on, and m the body's mass;
    `constants` are those of the equations of motion.
    """
    rate = cross_omega(series, UP, n)
    for i in range(3):
        store(series, n, UP_RATE + i, rate[i])
        after, next_ = load(series, n, UP + AFTER[i]), load(series, n, UP + NEXT[i])
        arm = multiply(load(constants, TIP, NEXT[i]), after)
        arm = rounded(add_product(arm, negative(load(constants, TIP, AFTER[i])), next_))
        store(series, n, ARM + i, arm)
        store(series, n, GAIN + i, multiply(load(constants, MASS_OVER_MOMENT, i), arm))
    mobility = _dot(series, n, ARM, GAIN)
    total = _dot(series, n, ARM, OTHER)
    bend = cross_omega(series, UP_RATE, n)
    for i in range(3):
        total = add_product(total, load(constants, TIP, i), bend[i])
    total = negative(rounded(total))
    if n == 0:
        mobility = add(mobility, load(constants, UP_WORLD, 2))
        total = add(total, load(constants, DOWN_AND_RADIUS, 0))
    store(series, n, MOBILITY, mobility)
    for k in range(1, n + 1):
        spread = negative(load(series, k, MOBILITY))
        total = add_product(total, spread, load(series, n - k, PRESSED))
    share = reciprocal(load(series, 0, MOBILITY))
    store(series, n, PRESSED, multiply(rounded(total), share))


@kernel
def _pressed_acceleration(series: Table, n: int, i: int) -> Number:
    """Return the n-th Taylor coefficient of component i of ω' of a body on a plane, u + f e.

    u is ω' without the plane's normal force, f this force divided by the mass, and f e what it adds
    to ω'. `series` has u, f and e up to order n.
    """
    total = load(series, n, OTHER + i)
    for k in range(n + 1):
        gain = load(series, n - k, GAIN + i)
        total = add_product(total, load(series, k, PRESSED), gain)
    return rounded(total)


@kernel
def support(series: Table, constants: Table, inverses: Table, terms: Terms, n: int) -> None:
    """Write Taylor coefficient n + 1 of ω of a body on a plane, given coefficient n of u.

    u is ω' without the normal force. Nothing is written if `terms` has no such plane. `extend`
    repeats these lines, because a call there costs a fifth of the time.

    Parameters
    ----------
    series : Taylor coefficients, a row for each order
    constants : constants of the equations of motion
    inverses : 1/n and 1/(2n), in column n
    terms : which terms the equations of motion have
    """
    if terms.world_vectors[ON_TABLE]:
        _press(series, constants, n)
        for i in range(3):
            rate = _pressed_acceleration(series, n, i)
            store(series, n + 1, OMEGA + i, multiply(load(inverses, 0, n + 1), rate))


@kernel
def extend(
    series: Table, constants: Table, inverses: Table, terms: Terms, first: int, last: int
) -> None:
    """Compute orders first + 1 to last of a Taylor series from orders 0 to first.

    `constants` and `terms` are those of the equations of motion. `inverses` is the table of
    `taylor.inverses_to`: 1/n and 1/(2n) in column n.
    """
    for n in range(first, last):
        products = _omega_products(series, n)
        for i in range(3):
            rate = _acceleration(series, constants, terms, n, i, products[i])
            store(series, n + 1, OMEGA + i, multiply(load(inverses, 0, n + 1), rate))
            store(series, n, OTHER + i, rate)
        if terms.world_vectors[ON_TABLE]:
            _press(series, constants, n)
            for i in range(3):
                rate = _pressed_acceleration(series, n, i)
                store(series, n + 1, OMEGA + i, multiply(load(inverses, 0, n + 1), rate))
        turn = _q_times_omega(series, n)
        for i in range(4):
            store(series, n + 1, Q + i, multiply(load(inverses, 1, n + 1), turn[i]))
        for v in range(len(WORLD_VECTORS)):
            if terms.world_vectors[v]:
                _turn_world_vector(series, inverses, n, WORLD_VECTORS[v])


@kernel
def _scaled_plus_cross(scale: Number, a: Vector, b: Vector) -> Vector:
    """Return scale · a + a × b for vectors a and b."""
    x = add_product(add_product(multiply(scale, a[0]), a[1], b[2]), negative(a[2]), b[1])
    y = add_product(add_product(multiply(scale, a[1]), a[2], b[0]), negative(a[0]), b[2])
    z = add_product(add_product(multiply(scale, a[2]), a[0], b[1]), negative(a[1]), b[0])
    return rounded(x), rounded(y), rounded(z)


@kernel
def see_world_vector(series: Table, constants: Table, row: int, column: int) -> None:
    """Write order 0 of q̄ v q: a vector v that is constant in the world, along the principal axes.

    With u = v q the result is Γ = q₀ u⃗ + u⃗ × q⃗ + (v · q⃗) q⃗. Formulas that assume |q| = 1 are
    shorter, but disagree with Γ' = Γ × ω where rounding has changed |q|; here |q| only scales Γ.

    Parameters
    ----------
    row : row of the constants that holds v
    column : column of the series from which on the result is written
    """
    q0 = load(series, 0, Q)
    q = _vector(series, 0, Q + 1)
    v = _vector(constants, row, 0)
    along = add_product(add_product(multiply(v[0], q[0]), v[1], q[1]), v[2], q[2])
    seen = _scaled_plus_cross(q0, _scaled_plus_cross(q0, v, q), q)
    for i in range(3):
        store(series, 0, column + i, rounded(add_product(seen[i], rounded(along), q[i])))
