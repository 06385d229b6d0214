#include "page/found_contacts.h"

#include <algorithm>

namespace foldproof {

FoundContacts::FoundContacts(CheckTotals& totals, Motions motions, const CheckSettings& settings)
    : searched(totals.contacts_found),
      unknown_frames(totals.contact_unknown_frames),
      contacts(std::move(totals.contacts)) {
  names.reserve(contacts.size());
  for (const auto& [object, text] : totals.notices) notices.push_back(motions[object]->name() + ": " + text);
  for (const Contact& contact : contacts) names.push_back(side_names(contact, motions, settings));
  groups = groups_of(contacts);
}

Json FoundContacts::json(std::uint64_t offset, std::uint64_t limit) const {
  Json items = Json::array();
  const std::uint64_t begin = std::min<std::uint64_t>(offset, contacts.size());
  const std::uint64_t end = begin + std::min<std::uint64_t>(limit, contacts.size() - begin);
  for (std::uint64_t k = begin; k < end; ++k)
    items.push_back(contact_json(contacts[k], names[k], groups[k], false));
  return {{"searched", searched},
          {"unknown_frames", unknown_frames},
          {"notices", notices},
          {"total", contacts.size()},
          {"items", std::move(items)}};
}

Json FoundContacts::json(std::uint64_t k) const {
  return contact_json(contacts[k], names[k], groups[k], true);
}

}  // namespace foldproof
