/// What an implicit solver asks on its way: trial steps of Newton iterations, and candidates for its barrier.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "competitor.h"

namespace foldproof::bench {

struct SimulationPlan {
  std::vector<PeerEntry> peers;
  Index steps = 200;  ///< Of the simulation, a hundredth of a second each.
  Index peer_every =
      16;            ///< Peers answer one question in so many, and so does foldproof without certificates.
  std::string only;  ///< One scene: "cloth", "pile" or "rod"; empty: all.
  bool processor_time = false;
  bool narrate = false;  ///< A line on the error stream that says how far it is.
};

/// The solver of examples/solver runs on a cloth that falls on a soft ball, a pile of soft balls and a rod
/// that is twisted, 20,000 to 40,000 triangles, and foldproof answers what it asks. Rows: scene and kind of
/// question, before the first contact and since; pairs of a barrier are found by both candidates and
/// close_pairs. Error: a question has no answer, or another one without
/// certificates.
Result<nlohmann::json> measure_simulation(const SimulationPlan& plan);

}  // namespace foldproof::bench
