"""`run --as`: an engine given the body in another description is judged as one of its own."""

import json
from pathlib import Path

import pytest
from spincheck.engines import engines
from spincheck.engines.encodings import ENCODINGS
from spincheck.reports.cli.app import app
from spincheck.reports.cli.run.encodings import encoded, encoding_rows, named_encodings
from spincheck.reports.cli.terminal import Complaint
from spincheck.scenarios import find, load
from typer.testing import CliRunner


@pytest.mark.processes
def test_it_stands_beside_the_engine_as_it_is_and_is_not_recommended(tmp_path: Path) -> None:
    out = str(tmp_path / "as.sqlite")
    run = ["run", "tennis-racket", "--quick", "--as", "turned", "--engine", "mujoco"]
    run += ["--method", "RK4", "--jobs", "1", "--out", out]
    done = CliRunner().invoke(app, [*run, "--json"])
    assert done.exit_code == 0, done.output
    record = json.loads(done.stdout)
    judged = {verdict["engine"]: verdict["verdict"] for verdict in record["verdicts"]}
    assert judged == {"mujoco": "converges", "mujoco as turned": "converges"}
    # Nothing is run again.
    again = CliRunner().invoke(app, run)
    assert "2 of 2 verdicts are stored already" in again.stderr
    assert "Best for tennis-racket: mujoco RK4 at" in again.stdout
    compared = CliRunner().invoke(app, ["compare", "mujoco", "mujoco as turned", "--from", out])
    assert (compared.exit_code, compared.stdout) == (0, "nothing changed\n")
    nowhere = CliRunner().invoke(app, ["compare", "mujoco", "mujoco as welded", "--from", out])
    assert "mujoco as welded: no result of it is in the file" in str(nowhere.exception)


def test_what_an_encoding_does_not_apply_to_is_left_out_with_the_reason(capsys) -> None:
    scenes = [load(path) for path in find(["fast-top"])]
    made = encoded([engines()["mujoco"]], named_encodings("Turned, offset,turned"), scenes)
    assert [engine.name for engine in made] == ["mujoco as turned"]
    assert capsys.readouterr().err == "Left out: mujoco as offset: it is of free bodies.\n"


def test_a_name_that_is_none_is_refused_and_all_are_explained() -> None:
    with pytest.raises(Complaint, match="got 'weldet'; did you mean 'welded'"):
        named_encodings("weldet")
    assert named_encodings("all") == tuple(ENCODINGS) == tuple(n["name"] for n in encoding_rows())
    assert named_encodings("") == ()
