"""What commands refuse of words that do not go together: one line, exit code 2, nothing written.

Wrong values of single options are planted in every one in `test_wrong_flags`.
"""

import pytest
from case_loops import each_case
from command_line import ended
from spincheck.reports.cli.run import running
from spincheck.reports.cli.terminal import BAD_INPUT

pytestmark = pytest.mark.slow

#: What is typed, and words of the line.
REFUSED = [
    ("show no-such-scene", "neither a file, a folder, nor a scene of the library"),
    ("show sphere --member -1", "'--member'"),
    ("show sphere --seed 7", "'--seed' is for a member of an ensemble"),
    ("show sphere --toml --json", "takes '--toml' or '--json', not both"),
    ("run sphere --engine bullet", "'--engine' must be one of "),
    ("run sphere --method RK5", "'--method' must be one of"),
    ("run sphere --timestep -1", "'--timestep' must be positive"),
    ("run sphere --timestep 1e9", "'--timestep' must be shorter than the window"),
    ("run sphere --time-limit 0", "'--time-limit' must be positive"),
    ("run sphere --seed 0", "'--seed' is for an ensemble"),
    ("run sphere --ensemble 3 --timestep 60", "must be shorter than the window of sphere"),
    ("run sphere --ensemble 3 --quick", "'--quick' is for ladders"),
    (
        "run sphere --ensemble 3 --timestep 0.1 --timestep 0.2",
        "given once with '--ensemble', got 2",
    ),
    ("run sphere --ensemble 3 --python python3", "'--python' is for versions"),
    ("run sphere --ensemble 3 --engine mujoco-file", "loads links of users'"),
    ("run --ensemble 3", "'--ensemble' takes scenes to scatter, got none"),
    ("run sphere --worlds 2", "mujoco steps one world at a time"),
    ("run --worlds 2", "'--worlds' needs a scene"),
    ("run sphere --worlds 0", "'--worlds' must be numbers from 1"),
    ("run sphere --worlds 2,x", "got '2,x'"),
    ("run sphere --device cuda:0", "'--device' is for batches"),
    ("run sphere --worlds 2 --quick", "'--quick' is not for '--worlds'"),
    ("run sphere --worlds 2 --ensemble 3", "'--ensemble' is not for '--worlds'"),
    ("recommend sphere --attitude 5d", "must be such as 1e-3 (rad) or 0.1deg"),
    ("recommend sphere --omega 3deg", "must be a number, such as 1e-3, got '3deg'"),
    ("recommend sphere --omega 0", "'--omega' must be positive, got 0"),
    ("recommend sphere --energy nan", "'--energy' must be positive, got nan"),
    ("recommend sphere --spins 1e-3", "'--spins': sphere has no spins of the rotors"),
    ("recommend sphere --from none.sqlite", "there is no file 'none.sqlite'"),
    (
        "reproduce sphere --engine mujoco --method RK4 --timestep 2ms",
        "must be a number of seconds, such as 0.002, got '2ms'",
    ),
    (
        "reproduce sphere --engine all --method default --timestep 1e-3",
        "'--engine' must name one engine, got 'all'",
    ),
    ("reference sphere --at -3", "'--at' must be a time from 0 on"),
    ("reference sphere --sensitivities --at -3", "'--at' must be a time from 0"),
    ("report none.sqlite", "no such result file"),
    ("report", "no such result file; 'spincheck run fast-top' writes one of a scene"),
    ("export sphere /proc/nowhere", "cannot be written"),
    ("export sphere out --sensitivities", "'--sensitivities' goes with '--truth'"),
]


@each_case(("words", "message"), REFUSED)
def test_what_is_refused_is_one_line_before_anything_is_run(words, message, tmp_path, monkeypatch):
    monkeypatch.setattr(running, "run_study", lambda *_, **__: pytest.fail("it runs"))
    code, out, err = ended(*words.split(), cwd=tmp_path)
    assert (code, out) == (BAD_INPUT, "")
    assert message in err
    assert err.startswith("Usage: ") or len(err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []
