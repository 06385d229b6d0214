/// Which pairs a check leaves out: those that CheckSettings::ignore names, and those of what stands still.
#pragma once

#include <functional>

#include "report/report.h"

namespace foldproof::inline internal {

/// The objects that stand still beside others that move, and that are tested among each other in the first
/// frame only. None with CheckSettings::still_pairs, or where only one frame is checked.
std::vector<Index> still_objects(Motions motions, const CheckSettings& settings, std::size_t frames);

/// Those of CheckSettings::ignore whose names are both known.
std::vector<std::array<std::string, 2>> known_pairs(Motions motions, const CheckSettings& settings);

/// Error: a name in CheckSettings::ignore is neither an object's nor a part's.
Result<void> check_names(Motions motions, const CheckSettings& settings);

/// Per object and triangle, whether it belongs to an object or a part of these names. Error: as check_names.
Result<std::vector<std::vector<std::uint8_t>>> triangles_named(Motions motions, const CheckSettings& settings,
                                                               std::span<const std::string> names);

/// Whether a contact is between two objects or parts of one of these pairs of names. The motions and settings
/// must outlive it. Error: as check_names.
Result<std::function<bool(const Contact&)>> contacts_between(
    Motions motions, const CheckSettings& settings, std::span<const std::array<std::string, 2>> pairs);

/// Which pairs are tested, apart from those that are ignored by name.
enum class TestedPairs : std::uint8_t {
  All,
  Moving,      ///< Not those among still objects, nor within one.
  AmongStill,  ///< Only these.
};
/// Null: none is left out. Error: as check_names.
Result<std::shared_ptr<const PairFilter>> filter_for(Motions motions, const CheckSettings& settings,
                                                     std::span<const Object> objects,
                                                     std::span<const Index> still, TestedPairs tested);

}  // namespace foldproof::inline internal
