"""Others' packages on the same logs; what is missing is said before anything is recorded."""

import bath_log
import pytest

from ichain_drake.errors import InputError
from ichain_drake.runs import baselines
from ichain_drake.runs.baselines import PCMCI, RUPTURES, check_baselines, pcmci_edges, ruptures_cuts
from ichain_drake.runs.discovery import METHODS
from ichain_drake.runs.discovery_scores import joined

PIECES = bath_log.pieces(3)


@pytest.mark.parametrize("method", [PCMCI, RUPTURES])
def test_a_missing_package_is_named(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr(baselines, "import_module", missing)
    with pytest.raises(InputError, match=r"is missing: pip install 'ichain_drake\[baselines\]'"):
        check_baselines([method])
    check_baselines([m for m in METHODS if m != method and "@" not in m])


def test_edges_between_objects_are_found() -> None:
    pytest.importorskip("tigramite", reason="tigramite is missing: pip install ichain_drake[baselines]")
    found = pcmci_edges(PIECES, bath_log.GRAPH)
    assert all(e.child not in ("hand", e.parent) for e in found)
    assert found


def test_change_points_are_rows() -> None:
    pytest.importorskip("ruptures", reason="ruptures is missing: pip install ichain_drake[baselines]")
    log = joined(PIECES, "log")
    found = ruptures_cuts(log, bath_log.GRAPH)
    assert found == sorted(set(found))
    assert all(0 < row < len(log) for row in found)
