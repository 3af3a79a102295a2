"""Learning an interaction graph from unordered demonstration pieces with active flags (paper sec. V, VI)."""

from ichain_drake.learning.findings import Finding, label_findings
from ichain_drake.learning.known import KnownObject, KnownParts
from ichain_drake.learning.learn import contradicted, learn_interactions
from ichain_drake.learning.model import InteractionModel
from ichain_drake.learning.reading import read_pieces
from ichain_drake.learning.report import report
from ichain_drake.learning.spec import InteractionSpec
from ichain_drake.learning.status.events import EdgeExamples, Switching, SwitchingWindow
from ichain_drake.learning.status.scores import event_f1, f1
from ichain_drake.learning.tick import LearnedInteraction

__all__ = [
    "EdgeExamples",
    "Finding",
    "InteractionModel",
    "InteractionSpec",
    "KnownObject",
    "KnownParts",
    "LearnedInteraction",
    "Switching",
    "SwitchingWindow",
    "contradicted",
    "event_f1",
    "f1",
    "label_findings",
    "learn_interactions",
    "read_pieces",
    "report",
]
