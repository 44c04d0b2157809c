"""Where Genesis keeps what it makes; Genesis itself is not needed."""

import os

from spincheck.engines.adapters.genesis.caches import FOLDERS, kernels_kept


def test_caches_are_in_spinchecks_folder_unless_the_user_named_another(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    users, ours = FOLDERS
    monkeypatch.setenv(ours, "to be deleted, and restored after the test")
    monkeypatch.delenv(ours)
    monkeypatch.setenv(users, "/elsewhere")
    with kernels_kept():
        print("nothing of this is seen")
    assert os.environ[users] == "/elsewhere"
    assert os.environ[ours] == str(tmp_path / "spincheck" / FOLDERS[ours])
