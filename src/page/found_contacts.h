/// The contacts of a check that has ended.
#pragma once

#include "report/json_values.h"

namespace foldproof {

/// Immutable. Contacts are sorted, the worst first.
struct FoundContacts {
  FoundContacts(CheckTotals& totals, Motions motions, const CheckSettings& settings);

  /// How many there are, and the requested part of the list, without triangles and curves.
  Json json(std::uint64_t offset, std::uint64_t limit) const;
  /// One of the list, with triangles and curves. Precondition: k < contacts.size().
  Json json(std::uint64_t k) const;

  bool searched;                     ///< Whether the check looked for contacts.
  std::uint64_t unknown_frames;      ///< Frames of which is not known what crosses.
  std::vector<std::string> notices;  ///< To be read before the contacts.
  std::vector<Contact> contacts;
  std::vector<std::array<std::string, 2>> names;  ///< Of the sides of each.
  std::vector<GroupOfContact> groups;             ///< Of each.
};

}  // namespace foldproof
