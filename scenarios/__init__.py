"""What is simulated: the scenario format, its loader, the library and trajectories."""

from .agreement import ErrorNorm, ErrorSeries, error_series, errors_between
from .body import Body
from .catalogue import LIBRARY, find, hiding_the_library, scenario_files
from .document import Document, Expect, Known, Published, Window
from .effects import EFFECTS, PUSHED, Effects, push
from .errors import Misfit, ScenarioError, did_you_mean, printable
from .float_array import FloatArray, read_only
from .load import from_tables, is_scenario, is_scene_name, load, load_each, loads
from .mechanics import angular_momentum_world, energy, energy_base, kinetic_energy, potential_energy
from .scales import check_scales
from .scenario import Scenario
from .signals import (
    EVERYWHERE,
    SIGNAL,
    SIGNALS,
    Distance,
    Errors,
    Signal,
    SignalName,
    errors_by_key,
    radius_of_gyration,
    signals_of,
)
from .start import Start
from .trajectory import Trajectory
