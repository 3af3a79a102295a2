"""Any Gymnasium environment as an object of a world (extra `games`)."""

from ichain_drake.objects.gymnasium_game.actions import ActionTerm
from ichain_drake.objects.gymnasium_game.environment import GameEnvironment, GameSpec
from ichain_drake.objects.gymnasium_game.game import GymnasiumGame
from ichain_drake.objects.gymnasium_game.snapshot import AttributeSnapshot, Snapshot

__all__ = ["ActionTerm", "AttributeSnapshot", "GameEnvironment", "GameSpec", "GymnasiumGame", "Snapshot"]
