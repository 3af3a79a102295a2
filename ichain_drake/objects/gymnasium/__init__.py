"""Any Gymnasium environment as an object of a world (extra `games`)."""

from ichain_drake.objects.gymnasium.actions import ActionTerm
from ichain_drake.objects.gymnasium.environment import GameEnvironment, GameSpec
from ichain_drake.objects.gymnasium.game import GymnasiumGame
from ichain_drake.objects.gymnasium.snapshot import AttributeSnapshot, Snapshot

__all__ = ["ActionTerm", "AttributeSnapshot", "GameEnvironment", "GameSpec", "GymnasiumGame", "Snapshot"]
