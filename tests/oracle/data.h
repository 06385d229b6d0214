/// The single queries of the real data.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "foldproof/io.h"
#include "oracle/data_directory.h"
#include "oracle/oracle.h"

namespace foldproof::oracle {

struct Query {
  Kind kind;
  FourPoints x0, x1;
  bool collides;
  std::string source;  ///< File and number, for messages.
};

/// Every single query of ccd-ground-truth/queries. Throws when a file is not as its README says.
std::vector<Query> read_queries(const std::filesystem::path& data);

/// One pair of a truth list: the rows of truth_vf.csv have two ids, those of truth_ee.csv four.
struct ListedPair {
  std::vector<Index> ids;
  bool collides;
};
std::vector<ListedPair> read_truth(const std::filesystem::path& csv);

/// Opens one motion; throws with the reader's message when that fails.
std::unique_ptr<Motion> open_motion(const std::vector<std::string>& arguments);

/// The motions that the data directory holds, by the names tests know them by: lion_poses, lion_anim,
/// hand_poses, hand_train, hand_anim, horse_poses, horse_gallop, elephant_poses, elephant_gallop, samba,
/// rumba, cloth_ball, rod_twist, cloth_funnel. Throws when there is no such motion.
std::unique_ptr<Motion> open_real_motion(const std::filesystem::path& data, const std::string& name);

/// FOLDPROOF_ALL_FRAMES=1: tests look at every frame, however long it takes.
bool all_frames();

}  // namespace foldproof::oracle
