"""What rounding does to methods: timesteps below which their errors grow, and biases, in words."""

from collections.abc import Sequence
from dataclasses import dataclass

from ...results.records import Pair
from .best_choice import finest_useful
from .report_data import ReportData
from .rounding_bias import rounding_bias
from .wording import plural, span

#: Number of methods that a sentence names.
NAMED = 4


@dataclass(frozen=True)
class Finest:
    """What rounding does to a method, over all scenes.

    Attributes
    ----------
    label : engine and method
    timesteps : timesteps below which errors grow by rounding, s, one for each scene that shows this
    scenes : number of scenes that the method was run on
    bias : the largest bias of rounding on any scene, ulp of single precision a step; None if no
        scene shows one
    """

    label: str
    timesteps: tuple[float, ...]
    scenes: int
    bias: float | None

    @property
    def timestep_in_words(self) -> str:
        """The range of the timesteps below which errors grow, and on how many scenes, as text.

        It is empty if there are none. The number is left out if all scenes show that errors grow.
        """
        if not self.timesteps:
            return ""
        shown, count = span(self.timesteps), len(self.timesteps)
        return shown if count == self.scenes else f"{shown} on {count} of {self.scenes} scenes"

    @property
    def bias_in_words(self) -> str:
        """The bias in words, such as "biased by 1.3 ulp a step"; empty if there is none."""
        return "" if self.bias is None else f"biased by {self.bias:.2g} ulp a step"


def finest_timesteps(gathered: ReportData) -> dict[Pair, Finest]:
    """Return what rounding does to methods, over all scenes.

    Only methods are included that have, on any scene, a timestep below which errors grow, or a
    bias. The methods with the longest such timesteps come first.
    """
    shown: dict[Pair, list[tuple[str, float | None, float | None]]] = {}
    for scene in gathered.scenes:
        for runs in scene.methods:
            seen = runs.label, finest_useful(scene, runs), rounding_bias(runs)
            shown.setdefault(runs.pair, []).append(seen)
    found = {
        pair: Finest(
            of_scenes[0][0],
            tuple(timestep for _, timestep, _ in of_scenes if timestep is not None),
            len(of_scenes),
            max((bias for _, _, bias in of_scenes if bias is not None), default=None),
        )
        for pair, of_scenes in shown.items()
    }
    longest = sorted(found.items(), key=lambda one: -max(one[1].timesteps, default=0.0))
    return {pair: one for pair, one in longest if one.timesteps or one.bias is not None}


def finest_in_words(shown: Sequence[Finest]) -> list[str]:
    """Return at most two sentences, without full stops, on methods that rounding affects.

    One is about timesteps below which errors grow; the other is about methods with a bias alone.
    """
    worse = [
        ", ".join(filter(None, (f"{one.label} {one.timestep_in_words}", one.bias_in_words)))
        for one in shown
        if one.timesteps
    ]
    biased = [f"{one.label} {one.bias_in_words}" for one in shown if not one.timesteps]
    sentences = {"Finer than this makes it worse": worse, "Rounding adds up step by step": biased}
    return [f"{what}: {_first(names)}" for what, names in sentences.items() if names]


def _first(names: Sequence[str]) -> str:
    """Return the first `NAMED` names as a text, with the number of the others."""
    more = len(names) - NAMED
    return "; ".join(names[:NAMED]) + (f"; and {plural(more, 'other method')}" if more > 0 else "")
