"""Elliptic and theta functions: mpmath's own, and elementary ones in the limits."""

import pytest
from case_loops import each_case
from mpmath import mp, mpf
from spincheck.reference.elliptic import Lattice, first_kind, jacobi, theta

DIGITS = 50
#: Sums of a dozen terms, each of which may be rounded several times.
BOUND = mpf(10) ** (3 - DIGITS)
PARAMETERS = ("1e-30", "0.01", "0.4", "0.5", "0.6", "0.99", "0.999999999999999999999999")
ARGUMENTS = ("0.0", "0.3", "0.9", "-1.2")


@pytest.fixture(autouse=True)
def _many_digits():
    with mp.workdps(DIGITS):
        yield


def lattice(m: str) -> Lattice:
    with mp.workdps(2 * DIGITS):
        return Lattice(mpf(m), 1 - mpf(m))


def jacobi_at(of: Lattice, u: str) -> tuple[mpf, ...]:
    return jacobi(of)(mpf(u) * of.scale)


@each_case("m", PARAMETERS)
def test_quarter_periods_are_complete_integrals(m):
    of = lattice(m)
    assert abs(of.K / mp.ellipk(of.m) - 1) < BOUND
    assert abs(of.K1 / mp.ellipk(of.m1) - 1) < BOUND


@each_case("m", PARAMETERS)
@each_case("phi", ["0.001", "0.8", "1.57"])
def test_integrals_of_the_first_kind_are_mpmaths(m, phi):
    of, phi = lattice(m), mpf(phi)
    ours = first_kind(mp.sin(phi) ** 2, mp.cos(phi) ** 2, of.m1)
    assert abs(ours / mp.ellipf(phi, of.m) - 1) < BOUND


@each_case("m", PARAMETERS)
@each_case("u", ARGUMENTS)
def test_jacobi_functions_are_mpmaths(m, u):
    of = lattice(m)
    theirs = [mp.ellipfun(name, mpf(u), m=of.m) for name in ("sn", "cn", "dn")]
    assert max(abs(a - b) for a, b in zip(jacobi_at(of, u), theirs, strict=True)) < BOUND


def test_a_parameter_off_by_a_hundred_bounds_would_show():
    exact = lattice("0.4")
    neighbour = Lattice(exact.m + 100 * BOUND, exact.m1 - 100 * BOUND)
    assert abs(jacobi_at(neighbour, "0.9")[2] - jacobi_at(exact, "0.9")[2]) > BOUND


@each_case(
    ("m", "limits"),
    [(0, (mp.sin, mp.cos, lambda u: 1)), (1, (mp.tanh, mp.sech, mp.sech))],
)
def test_at_parameters_zero_and_one_they_are_elementary(m, limits):
    u, values = mpf("0.9"), jacobi_at(Lattice(mpf(m), mpf(1 - m)), "0.9")
    assert max(abs(a - limit(u)) for a, limit in zip(values, limits, strict=True)) < BOUND


@each_case("doubled", [False, True])
@each_case("m", PARAMETERS)
@each_case("n", [1, 2, 3, 4])
def test_shifted_theta_functions_are_mpmaths_up_to_the_factor_left_out(n, m, doubled):
    """Two ratios at different x agree, the Gaussian of Jacobi's transformation put back."""
    of, y, tall = lattice(m), mpf("0.3"), 2 if doubled else 1
    ours = theta(n, of, y, doubled)
    ratios = []
    for u in (mpf("0.2"), mpf("0.7")):
        # Near m = 1 the nome is near 1 and the terms of its series cancel.
        with mp.workdps(2 * DIGITS):
            K, K1 = mp.ellipk(of.m), tall * mp.ellipk(of.m1)
            z = mp.pi * mp.mpc(u, -y) / (2 * K)
            theirs = mp.jtheta(n, z, mp.exp(-mp.pi * K1 / K))
            if of.hyperbolic:
                theirs *= mp.exp(z**2 * K / (mp.pi * K1))
        ratios.append(ours.value_and_slope(u * of.scale)[0] / theirs)
    assert abs(ratios[1] / ratios[0] - 1) < BOUND


@each_case("m", ["0.3", "0.7"])
@each_case("n", [1, 2, 3, 4])
def test_slopes_are_derivatives(n, m):
    function = theta(n, lattice(m), mpf("0.3"), doubled=True)
    x, step = mpf("0.4"), mpf(10) ** (-DIGITS // 3)
    forward, backward = (function.value_and_slope(x + h)[0] for h in (step, -step))
    slope = function.value_and_slope(x)[1]
    # The difference quotient leaves out step² f‴/6, with f‴ a few hundred at most.
    assert abs((forward - backward) / (2 * step) - slope) < 1000 * step**2
