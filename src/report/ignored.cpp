#include "report/ignored.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "base/nearest_name.h"
#include "base/try.h"

namespace foldproof {
namespace {

// What a name stands for: an object as it was named, else all parts of that name, else the one object whose
// file has this name, with or without its extension, else a part of one object: the names of both with ":"
// between, the object's as it was named, else that of its file.
class Named {
 public:
  Named(const std::string& name, Motions motions, const CheckSettings& settings)
      : name_(name), motions_(motions), settings_(settings) {
    for (Index i = 0; i < motions.size(); ++i) {
      const auto& parts = parts_of(i, motions, settings).names;
      any_object_ |= motions[i]->name() == name;
      any_part_ |= std::ranges::find(parts, name) != parts.end();
      if (has_file_name(i, name)) file_ = of_file_++ == 0 ? i : kNoIndex;
      const auto own = std::ranges::find_if(parts, [&](const auto& part) { return is_part_of(i, part); });
      if (own == parts.end()) continue;
      const bool is_exact = name == motions[i]->name() + ":" + *own;
      if (!is_exact && exact_owner_) continue;
      if (is_exact && !exact_owner_) owners_ = 0;
      exact_owner_ = is_exact;
      owner_ = owners_++ == 0 ? i : kNoIndex;
      own_part_ = *own;
    }
  }

  bool found() const { return any_object_ || any_part_ || of_file_ == 1 || (of_file_ == 0 && owners_ == 1); }
  bool is(Index object, Index part) const {
    if (any_object_) return motions_[object]->name() == name_;
    if (any_part_) return has_part_name(object, part, name_);
    if (of_file_ > 0) return object == file_;
    return object == owner_ && has_part_name(object, part, own_part_);
  }

  Error error() const {
    if (of_file_ > 1) {
      return {fmt::format("'{}'", name_), fmt::format("is the file name of {} objects", of_file_),
              "name the one that is meant with its folder"};
    }
    if (owners_ > 1) {
      return {fmt::format("'{}'", name_), fmt::format("is a part of {} objects", owners_),
              "name the object that is meant with its folder"};
    }
    std::vector<std::string> names;
    for (Index i = 0; i < motions_.size(); ++i) {
      names.push_back(motions_[i]->name());
      names.push_back(std::filesystem::path(motions_[i]->name()).stem().string());
      const auto& parts = parts_of(i, motions_, settings_).names;
      names.insert(names.end(), parts.begin(), parts.end());
    }
    const auto near = nearest_name(name_, names);
    return {fmt::format("'{}'", name_), "is neither an object nor a part of one",
            near ? fmt::format("did you mean '{}'?", *near) : "give one of " + listed(names)};
  }

 private:
  bool has_file_name(Index object, std::string_view name) const {
    const std::filesystem::path path = motions_[object]->name();
    return path.filename() == name || path.stem() == name;
  }
  bool has_part_name(Index object, Index part, const std::string& name) const {
    return part != kNoIndex && parts_of(object, motions_, settings_).names[part] == name;
  }
  bool is_part_of(Index object, const std::string& part) const {
    if (!name_.ends_with(":" + part)) return false;
    const std::string_view owner = std::string_view(name_).substr(0, name_.size() - part.size() - 1);
    return motions_[object]->name() == owner || has_file_name(object, owner);
  }
  static std::string listed(const std::vector<std::string>& names) {
    constexpr std::size_t kMost = 6;
    std::vector<std::string> different;
    for (const std::string& name : names) {
      if (std::ranges::find(different, name) == different.end()) different.push_back(name);
    }
    std::string text;
    for (std::size_t i = 0; i < std::min(kMost, different.size()); ++i)
      text += fmt::format("{}'{}'", i == 0 ? "" : ", ", different[i]);
    if (different.size() > kMost) text += fmt::format(" and {} more", different.size() - kMost);
    return text;
  }

  const std::string& name_;
  Motions motions_;
  const CheckSettings& settings_;
  bool any_object_ = false, any_part_ = false;
  Index of_file_ = 0, file_ = kNoIndex;
  Index owners_ = 0, owner_ = kNoIndex;  // of a part that is named with its object
  bool exact_owner_ = false;             // which was given as it was named
  std::string own_part_;
};

using NamedPair = std::array<Named, 2>;

// Labels for everything that the names and standing still tell apart, so that there are few.
class PairLabels {
 public:
  PairLabels(Motions motions, const CheckSettings& settings, std::span<const NamedPair> named,
             std::span<const Index> still) {
    for (Index i = 0; i < motions.size(); ++i) {
      const ObjectParts& parts = parts_of(i, motions, settings);
      const bool stands = std::ranges::find(still, i) != still.end();
      const auto label = [&](Index part) {
        std::vector<bool> marks{stands};
        for (const auto& [a, b] : named) {
          marks.push_back(a.is(i, part));
          marks.push_back(b.is(i, part));
        }
        return numbers_.try_emplace(std::move(marks), static_cast<Index>(numbers_.size())).first->second;
      };
      auto& labels = of_.emplace_back();
      if (parts.of_triangle.empty()) {
        labels.push_back(label(kNoIndex));
        continue;
      }
      std::vector<Index> of_part;
      for (Index part = 0; part < parts.names.size(); ++part) of_part.push_back(label(part));
      for (const Index part : parts.of_triangle) labels.push_back(of_part[part]);
    }
  }

  const std::vector<std::vector<Index>>& of_objects() const { return of_; }

  // The pairs of labels with two marks, each in the order of its labels.
  template <class Ignores>
  std::vector<std::array<Index, 2>> pairs(Ignores ignores) const {
    std::vector<std::array<Index, 2>> out;
    for (const auto& [a, label_a] : numbers_) {
      for (const auto& [b, label_b] : numbers_) {
        if (label_a <= label_b && (ignores(a, b) || ignores(b, a))) out.push_back({label_a, label_b});
      }
    }
    return out;
  }

 private:
  std::map<std::vector<bool>, Index> numbers_;  // label of each set of marks
  std::vector<std::vector<Index>> of_;
};

Result<std::vector<NamedPair>> resolve(Motions motions, const CheckSettings& settings) {
  std::vector<NamedPair> named;
  for (const auto& [a, b] : settings.ignore) {
    named.push_back({Named(a, motions, settings), Named(b, motions, settings)});
    for (const Named& side : named.back()) {
      if (!side.found()) return tl::unexpected(side.error());
    }
  }
  return named;
}

}  // namespace

namespace internal {

std::vector<Index> still_objects(Motions motions, const CheckSettings& settings, std::size_t frames) {
  std::vector<Index> still;
  if (settings.still_pairs || frames < 2) return still;
  for (Index i = 0; i < motions.size(); ++i) {
    if (motions[i]->info().still) still.push_back(i);
  }
  return still;
}

std::vector<std::array<std::string, 2>> known_pairs(Motions motions, const CheckSettings& settings) {
  auto known = settings.ignore;
  std::erase_if(known, [&](const auto& pair) {
    return !Named(pair[0], motions, settings).found() || !Named(pair[1], motions, settings).found();
  });
  return known;
}

Result<void> check_names(Motions motions, const CheckSettings& settings) {
  FOLDPROOF_TRY(resolve(motions, settings));
  return {};
}

Result<std::shared_ptr<const PairFilter>> filter_for(Motions motions, const CheckSettings& settings,
                                                     std::span<const Object> objects,
                                                     std::span<const Index> still, TestedPairs tested) {
  const auto named = FOLDPROOF_TRY(resolve(motions, settings));
  const bool has_still = tested != TestedPairs::All && !still.empty();
  if (named.empty() && !has_still) return nullptr;
  const PairLabels labels(motions, settings, named, still);
  const auto ignored = labels.pairs([&](const std::vector<bool>& a, const std::vector<bool>& b) {
    for (std::size_t k = 0; k < named.size(); ++k) {
      if (a[1 + 2 * k] && b[2 + 2 * k]) return true;
    }
    return has_still && (tested == TestedPairs::Moving ? a[0] && b[0] : !a[0] || !b[0]);
  });
  return ignore_labels(objects, labels.of_objects(), ignored);
}

}  // namespace internal

std::string ignored_pairs(const CheckSettings& settings) {
  std::string text;
  for (const auto& [a, b] : settings.ignore) {
    text += text.empty() ? "pairs of " : ", of ";
    text += a;
    text += a == b ? " with itself" : " and " + b;
  }
  return text.empty() ? text : text + " were ignored";
}

std::string still_pairs(Motions motions, const CheckSettings& settings, const CheckTotals& totals) {
  const auto& still = totals.still;
  const bool several = still.size() > 1;
  if (still.empty() || (!several && !settings.step.within)) return "";
  const auto name = [&](Index object) { return motions[object]->name(); };
  std::string text = still.size() > 2 ? fmt::format("{} objects", still.size())
                     : several        ? name(still[0]) + " and " + name(still[1])
                                      : name(still[0]);
  text += several ? " stand still" : " stands still";
  if (!totals.still_crossing) return text + "; pairs among what stands still were not tested";
  const std::uint64_t count = *totals.still_crossing;
  const bool thick = settings.step.thickness > 0 && !settings.poses;
  if (count == 0 && !thick) return "";
  if (count > 0) {
    const auto& crossings = totals.still_crossings;
    const auto most = std::ranges::max_element(crossings, {}, &CheckTotals::StillCrossing::crossings);
    const auto pairs = [](std::uint64_t n) {
      return fmt::format("{} pair{} of triangles", n, n == 1 ? "" : "s");
    };
    if (crossings.size() == 1 && most->object_a == most->object_b) {
      text = fmt::format("{} stands still and crosses itself at {}", name(most->object_a), pairs(count));
    } else if (crossings.size() == 1) {
      text = fmt::format("{} and {} stand still and cross each other at {}", name(most->object_a),
                         name(most->object_b), pairs(count));
    } else {
      text += fmt::format(" and cross each other or themselves at {}, {} of them between {} and {}",
                          pairs(count), most->crossings, name(most->object_a), name(most->object_b));
    }
  }
  return thick ? text + "; among what stands still nothing was tested for the thickness" : text;
}

Result<std::vector<std::vector<std::uint8_t>>> internal::triangles_named(Motions motions,
                                                                         const CheckSettings& settings,
                                                                         std::span<const std::string> names) {
  std::vector<std::vector<std::uint8_t>> out;
  for (const auto& motion : motions) out.emplace_back(motion->topology().triangles().size(), 0);
  for (const std::string& name : names) {
    const Named named(name, motions, settings);
    if (!named.found()) return tl::unexpected(named.error());
    for (Index i = 0; i < motions.size(); ++i) {
      const auto& parts = parts_of(i, motions, settings).of_triangle;
      for (std::size_t t = 0; t < out[i].size(); ++t)
        out[i][t] |= named.is(i, parts.empty() ? kNoIndex : parts[t]);
    }
  }
  return out;
}

Result<std::function<bool(const Contact&)>> internal::contacts_between(
    Motions motions, const CheckSettings& settings, std::span<const std::array<std::string, 2>> pairs) {
  CheckSettings named = settings;
  named.ignore.assign(pairs.begin(), pairs.end());
  FOLDPROOF_TRY(check_names(motions, named));
  return [motions, named](const Contact& contact) {
    const auto is = [&](const std::string& name, const Contact::Side& side) {
      return Named(name, motions, named).is(side.object, side.part);
    };
    const Contact::Side &a = contact.sides[0], &b = contact.sides[1];
    return std::ranges::any_of(named.ignore, [&](const auto& pair) {
      return (is(pair[0], a) && is(pair[1], b)) || (is(pair[0], b) && is(pair[1], a));
    });
  };
}

}  // namespace foldproof
