"""Record demonstrations, learn both links, and follow a path with the learned models."""

import sys

from ichain_drake import TimedPath, follow, learn_chain, load_scenario, make_controller

samples = int(sys.argv[1]) if len(sys.argv) > 1 else 500
scenario = load_scenario("car_game", [f"learning.samples={samples}"], physics="ideal")
pieces = list(scenario.record_demonstrations())
for piece in pieces:
    print(f"{piece.name}: {len(piece)} rows, {', '.join(piece.table.columns)}")

candidates = scenario.config.learning.candidates()
chain = learn_chain(pieces, scenario.graph, scenario.target, scenario.target_variables, candidates)
for link in chain.links:
    print(f"{link.interaction.name}: {link.forward.spec}, cross-validation score {link.forward.score:.4f}")

limits = scenario.path_limits()
controller = make_controller(chain, "predictive", limits)
path = TimedPath(scenario.reference_paths()["eight"], limits)
result = follow(scenario, chain, controller, "eight", path, number=0)
print(f"eight: completed {result.completed}, mean error {result.error:.3f} px after {samples} + {samples} samples")
