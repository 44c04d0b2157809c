"""CPU time of derivatives: the exact ones over the exact motion, engines' over a plain step.

Ratios are of CPU seconds, the two in turn in one process: their median over the rounds, with the
distance of the quartiles. Engines are those that are installed, but for those that compile.
"""

from collections.abc import Callable
from functools import partial

from bench_timing import in_turn, ratio
from rich.console import Console
from rich.table import Table
from spincheck.engines import engines
from spincheck.reference import sensitivity, solve_cheaply
from spincheck.scenarios import Scenario, find, load

ROUNDS = 20
#: Number of times of the exact motion, of steps that an engine takes at once, and of derivatives.
SAMPLES, STEPS, CALLS = 100, 1000, 20
SCENES = ("t-handle", "fast-top", "gliding-top")
#: Drake's ball joint turns to its singularity in so many steps.
CASES = [
    ("mujoco", "Euler", "t-handle"),
    ("mujoco", "Euler", "fast-top"),
    ("pin", "RK4", "fast-top"),
    ("drake", "discrete", "t-handle"),
]


def of_the_motion(scenario: Scenario) -> tuple[float, float]:
    """All derivatives at times of the window, over the motion there."""
    times = scenario.times[:: max(1, len(scenario.times) // SAMPLES)]
    (solution,) = solve_cheaply(scenario, [times])
    seconds = in_turn(
        ROUNDS,
        [
            lambda: solve_cheaply(scenario, [times]),
            lambda: sensitivity(scenario, solution.trajectory),
        ],
    )
    return ratio(seconds[:, 1] / seconds[:, 0])


def of_a_step(scenario: Scenario, engine: str, method: str) -> dict[str, tuple[float, float]]:
    """Each derivative that an engine gives, by name."""
    timestep = 1e-3
    with engines()[engine].open(scenario, engines()[engine].method(method), timestep) as session:
        offered = {name: one.compute for name, one in session.derivatives().items()}
        many = [partial(repeated, one) for one in offered.values()]
        seconds = in_turn(ROUNDS, [lambda: session.advance(STEPS), *many])
    of_one = STEPS / CALLS * seconds[:, 1:] / seconds[:, :1]
    return {name: ratio(of_one[:, k]) for k, name in enumerate(offered)}


def repeated(compute: Callable[[], object]) -> None:
    """Call so often that the first call's cold caches do not count."""
    for _ in range(CALLS):
        compute()


def main() -> None:
    """Measure, and print a table."""
    grid = Table("scene", "derivative", "cost", title="CPU time of derivatives")
    scenes = dict(zip(SCENES, map(load, find(list(SCENES))), strict=True))
    for name, scene in scenes.items():
        add(grid, name, "exact, over the exact motion", of_the_motion(scene))
    for engine, method, name in CASES:
        if engine in engines():
            for derivative, cost in of_a_step(scenes[name], engine, method).items():
                add(grid, name, f"{engine} {method} {derivative}, over a step", cost)
    Console(width=120).print(grid)


def add(grid: Table, scene: str, derivative: str, cost: tuple[float, float]) -> None:
    """One line of the table: a median, and the distance of the quartiles."""
    grid.add_row(scene, derivative, f"{cost[0]:.1f} ± {cost[1]:.1f}")


if __name__ == "__main__":
    main()
