/// Contacts of the same two parts, as a person would speak of them: one thing that happens several times.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "foldproof/contacts.h"

namespace foldproof {

struct ContactGroup {
  std::vector<std::size_t> contacts;  ///< Indices of the grouped contacts, the worst first.
  std::size_t crossing = 0;           ///< How many of them cross; the others only touch.
  /// Two that cross do so at one time: there are several places rather than several times.
  bool at_once = false;
};

/// Whether the sides of a contact have names of their own: two objects, or parts.
bool has_names(const Contact& contact);

/// Whether something goes through something, as far as is known: else it only touches.
inline bool goes_through(const Contact& contact) { return contact.pierces || !contact.touching(); }

/// Groups contacts that are sorted, the worst first: by their sides' names; without, by the triangles that
/// they share on both sides. Groups come in the order of their worst contacts.
std::vector<ContactGroup> group_contacts(std::span<const Contact> contacts);
/// "4 times", "in 3 places"; empty for one.
std::string how_often(const ContactGroup& group);

/// The group of a contact, as lists name it.
struct GroupOfContact {
  std::size_t number = 0;
  std::string often;  ///< how_often() of the group.
};
/// Of each contact. They are sorted, the worst first.
std::vector<GroupOfContact> groups_of(std::span<const Contact> contacts);

/// How deep: "6.6 cm", "at least 6.6 cm"; without a depth how long the curves are, "along 6.6 cm".
std::string depth_text(const ContactFrame& frame, const std::string& unit);

/// A length in the metric unit that fits it, or in `unit`, with two digits: "6.6 cm".
std::string length_text(double length, const std::string& unit);

}  // namespace foldproof
