"""Cells: kept, found again, made anew when damaged, known by their parameters."""

from __future__ import annotations

import numpy as np
import pytest

from nephrite.atlas.store import NotYetError, Store


def two():
    return {"a": np.arange(3.0), "b": np.asarray(2)}


def never():
    raise AssertionError("computed again")


def test_a_cell_is_kept_and_found_by_another_run(tmp_path):
    first = Store(tmp_path).cell("plane 1", {"g": 0.5}, two)
    later = Store(tmp_path)
    found = later.cell("plane 1", {"g": 0.5}, never)
    assert np.array_equal(found["a"], first["a"])
    assert found["b"] == 2
    assert later.made == 0
    assert 0.0 < later.seconds < 10.0


def test_other_parameters_or_another_version_are_another_cell(tmp_path, monkeypatch):
    store = Store(tmp_path)
    store.cell("plane", {"g": 0.5}, two)
    store.cell("plane", {"g": 0.6}, two)
    assert store.made == 2
    monkeypatch.setattr("nephrite.atlas.store.__version__", "0.0.0")
    store.cell("plane", {"g": 0.5}, two)
    assert store.made == 3
    assert len(list(tmp_path.iterdir())) == 3


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 not a whole file", None])
def test_a_damaged_file_counts_as_none(tmp_path, content):
    Store(tmp_path).cell("plane", {}, two)
    (path,) = tmp_path.iterdir()
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] if content is None else content)
    store = Store(tmp_path)
    assert store.cell("plane", {}, two)["b"] == 2
    assert store.made == 1
    assert Store(tmp_path).cell("plane", {}, never)["b"] == 2


def test_nothing_is_computed_when_time_is_over_but_found_it_is(tmp_path):
    Store(tmp_path).cell("plane", {}, two)
    late = Store(tmp_path, seconds=-1.0)
    assert late.cell("plane", {}, never)["b"] == 2
    with pytest.raises(NotYetError):
        late.cell("plane", {"g": 1}, never)


def test_fresh_replaces_what_was_kept_and_computes_once(tmp_path):
    Store(tmp_path).cell("plane", {}, lambda: {"a": np.zeros(1)})
    fresh = Store(tmp_path, fresh=True)
    for _ in range(2):
        assert fresh.cell("plane", {}, two)["b"] == 2
    assert fresh.made == 1
    assert Store(tmp_path).cell("plane", {}, never)["b"] == 2


def test_without_a_folder_cells_are_remembered():
    told = []
    store = Store(None, on_cell=told.append)
    for _ in range(2):
        store.cell("plane", {}, two)
    assert told == ["plane"]
