#include "report/contact_groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <unordered_map>

namespace foldproof {
namespace {

using Side = std::pair<Index, Index>;  // object, part

std::array<Side, 2> sides_of(const Contact& contact) {
  std::array<Side, 2> sides;
  for (std::size_t k = 0; k < 2; ++k) sides[k] = {contact.sides[k].object, contact.sides[k].part};
  if (sides[1] < sides[0]) std::swap(sides[0], sides[1]);
  return sides;
}

/// Finds the group whose worst contact shares triangles with a contact on both sides.
class ByTriangles {
 public:
  std::optional<std::size_t> find(const Contact& contact) const {
    const auto first = groups_at(contact, 0), second = groups_at(contact, 1);
    for (const auto& [group, sides] : first) {
      const auto other = second.find(group);
      if (other == second.end()) continue;
      // The first side meets one of the group's, the second the other.
      if ((sides & 1 && other->second & 2) || (sides & 2 && other->second & 1)) return group;
    }
    return std::nullopt;
  }

  void add(const Contact& contact, std::size_t group) {
    for (std::uint8_t side = 0; side < 2; ++side) {
      for (const Index t : contact.sides[side].triangles)
        at_[key(contact, t)].emplace_back(group, std::uint8_t{1} << side);
    }
  }

 private:
  static std::uint64_t key(const Contact& contact, Index triangle) {
    return std::uint64_t{contact.sides[0].object} << 32 | triangle;
  }
  /// Which sides of which groups a side shares triangles with.
  std::map<std::size_t, int> groups_at(const Contact& contact, std::size_t side) const {
    std::map<std::size_t, int> groups;
    for (const Index t : contact.sides[side].triangles) {
      const auto found = at_.find(key(contact, t));
      if (found == at_.end()) continue;
      for (const auto& [group, sides] : found->second) groups[group] |= sides;
    }
    return groups;
  }

  std::unordered_map<std::uint64_t, std::vector<std::pair<std::size_t, int>>> at_;
};

bool are_at_once(std::span<const Contact> contacts, const ContactGroup& group) {
  std::vector<std::array<double, 2>> times;
  for (const std::size_t k : group.contacts) {
    const Contact& contact = contacts[k];
    if (goes_through(contact)) times.push_back({contact.first_time, contact.last_time});
  }
  std::sort(times.begin(), times.end());
  for (std::size_t k = 1; k < times.size(); ++k) {
    if (times[k][0] <= times[k - 1][1]) return true;
  }
  return false;
}

}  // namespace

bool has_names(const Contact& contact) {
  const auto& [a, b] = contact.sides;
  return a.object != b.object || (a.part != kNoIndex && b.part != kNoIndex);
}

std::vector<ContactGroup> group_contacts(std::span<const Contact> contacts) {
  std::vector<ContactGroup> groups;
  std::map<std::array<Side, 2>, std::size_t> by_name;
  ByTriangles by_triangles;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const Contact& contact = contacts[k];
    std::optional<std::size_t> group;
    if (has_names(contact)) {
      group = by_name.try_emplace(sides_of(contact), groups.size()).first->second;
    } else {
      group = by_triangles.find(contact);
      if (!group) by_triangles.add(contact, groups.size());
    }
    if (!group || *group == groups.size()) {
      group = groups.size();
      groups.emplace_back();
    }
    groups[*group].contacts.push_back(k);
    groups[*group].crossing += goes_through(contact);
  }
  for (ContactGroup& group : groups) group.at_once = are_at_once(contacts, group);
  return groups;
}

std::string how_often(const ContactGroup& group) {
  const std::size_t count = group.crossing > 0 ? group.crossing : group.contacts.size();
  if (count < 2) return "";
  if (group.at_once) return fmt::format("in {} places", count);
  return count == 2 ? "twice" : fmt::format("{} times", count);
}

std::vector<GroupOfContact> groups_of(std::span<const Contact> contacts) {
  const auto groups = group_contacts(contacts);
  std::vector<GroupOfContact> of_each(contacts.size());
  for (std::size_t k = 0; k < groups.size(); ++k) {
    for (const std::size_t contact : groups[k].contacts) of_each[contact] = {k, how_often(groups[k])};
  }
  return of_each;
}

std::string depth_text(const ContactFrame& frame, const std::string& unit) {
  if (!frame.depth) return "along " + length_text(frame.curve_length, unit);
  return (frame.at_least ? "at least " : "") + length_text(*frame.depth, unit);
}

std::string length_text(double length, const std::string& unit) {
  static constexpr std::array<std::pair<const char*, double>, 6> kMetric{
      {{"km", 1e3}, {"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}, {"nm", 1e-9}}};
  const auto digits = [](double value) {  // two, without an exponent where that is short
    const double size = std::abs(value);
    if (!(size >= 99.5)) return fmt::format("{:.2g}", value);
    const double step = std::pow(10, std::floor(std::log10(size)) - 1);
    return size < 1e6 ? fmt::format("{:.0f}", std::round(value / step) * step) : fmt::format("{:.2g}", value);
  };
  const auto known = std::ranges::find(kMetric, unit, [](const auto& each) { return each.first; });
  if (known == kMetric.end()) return digits(length) + (unit.empty() ? "" : " " + unit);
  const double meters = length * known->second;
  // What rounds to one of the next larger unit has that unit.
  const auto fits =
      std::ranges::find_if(kMetric, [&](const auto& each) { return meters >= 0.995 * each.second; });
  const auto& [name, size] = length > 0 ? (fits == kMetric.end() ? kMetric.back() : *fits) : *known;
  return fmt::format("{} {}", digits(meters / size), name);
}

}  // namespace foldproof
