"""Where results come from: code that changed is other code."""

import importlib.util
import sys

from ichain_drake.runs.provenance import code_hash
from ichain_drake.systems.kettle.scenario import KettleScenario


def load(file, monkeypatch):
    spec = importlib.util.spec_from_file_location("own_system", file)
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "own_system", module)
    spec.loader.exec_module(module)
    return module.Own


def test_the_hash_is_of_the_package_and_of_a_users_own_file(tmp_path, monkeypatch):
    file = tmp_path / "own_system.py"
    file.write_text("class Own:\n    a = 1\n")
    own = load(file, monkeypatch)
    assert code_hash() == code_hash([KettleScenario])
    before = code_hash([own])
    assert before == code_hash([own]) != code_hash()
    file.write_text("class Own:\n    a = 2\n")
    assert code_hash([own]) != before
