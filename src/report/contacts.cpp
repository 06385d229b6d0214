#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <unordered_map>

#include "base/try.h"
#include "io/bytes.h"
#include "io/readers.h"
#include "report/report.h"
#include "report/text_file.h"
#include "report/verdict.h"

namespace foldproof {
namespace {

std::string quoted(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string out = "\"";
  for (const char c : name) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

class ContactsCsv : public ReportWriter {
 public:
  ContactsCsv(FileWriter file, Motions motions, const CheckSettings& settings)
      : file_(std::move(file)), motions_(motions), settings_(settings) {
    file_.add(
        "contact,side_a,side_b,from_start,healed,first_time,last_time,pairs,time,crossings,triangles,"
        "curve_length,closed,area_a,area_b,depth,pierces,at_least,touching\n");
  }

  Result<void> step(const CheckedStep&) override { return {}; }

  Result<void> finish(const CheckTotals& totals) override {
    if (!totals.lists_all())
      file_.add("# contacts join the {} listed of {} pairs\n", totals.listed.sum(), totals.collisions.sum());
    for (const Contact& contact : totals.contacts) {
      const auto names = side_names(contact, motions_, settings_);
      const std::string begin = fmt::format("{},{},{},{:d},{:d},{},{},{}", contact.number, quoted(names[0]),
                                            quoted(names[1]), contact.from_start, contact.healed,
                                            contact.first_time, contact.last_time, contact.pairs);
      if (contact.frames.empty()) file_.add("{},,,,,,,,,{:d},,\n", begin, contact.pierces);
      for (const ContactFrame& frame : contact.frames) {
        file_.add("{},{},{},{},{},{:d},{},{},{},{:d},{:d},{:d}\n", begin, frame.time, frame.crossings,
                  frame.triangles, frame.curve_length, frame.closed, number(frame.area[0]),
                  number(frame.area[1]), number(frame.depth), contact.pierces, frame.at_least,
                  frame.touching);
      }
      FOLDPROOF_TRY(file_.flush_if_large());
    }
    return file_.commit();
  }

 private:
  static std::string number(const std::optional<double>& value) {
    return value ? fmt::format("{}", *value) : "";
  }

  TextFile file_;
  Motions motions_;
  const CheckSettings& settings_;
};

}  // namespace

Result<ObjectParts> read_parts(const std::string& path, const Topology& topology) {
  std::error_code code;
  if (!std::filesystem::exists(path, code) && !code) return io::does_not_exist(path);
  std::ifstream file{std::filesystem::path(path)};
  if (!file) return fail(ErrorCode::FileAccess, path, "cannot be read", "check the permissions");
  ObjectParts parts;
  std::unordered_map<std::string, Index> known;
  const std::size_t count = topology.face_count();
  std::string line;
  std::size_t lines = 0;
  while (std::getline(file, line)) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    ++lines;
    if (line.empty())
      return fail(ErrorCode::InvalidFile, fmt::format("{}:{}", path, lines), "is empty",
                  "write the name of the triangle's part on each line");
    if (lines > count) continue;
    const auto [at, is_new] = known.try_emplace(line, static_cast<Index>(parts.names.size()));
    if (is_new) parts.names.push_back(line);
    parts.of_triangle.push_back(at->second);
  }
  if (lines != count) {
    return fail(ErrorCode::InvalidFile, path, fmt::format("has {} lines for {} triangles", lines, count),
                "write one name per triangle; polygons are cut into triangles as fans");
  }
  io::add_parts(topology, parts);
  return parts;
}

const ObjectParts& parts_of(Index object, Motions motions, const CheckSettings& settings) {
  return settings.parts.empty() ? motions[object]->info().parts : settings.parts[object];
}

std::string unit_of(Motions motions, const CheckSettings& settings) {
  if (!settings.unit.empty() || motions.empty()) return settings.unit;
  const std::string unit = motions.front()->info().unit;
  const bool all =
      std::ranges::all_of(motions, [&](const auto& motion) { return motion->info().unit == unit; });
  return all ? unit : "";
}

std::array<std::string, 2> side_names(const Contact& contact, Motions motions,
                                      const CheckSettings& settings) {
  std::array<std::string, 2> names;
  for (std::size_t side = 0; side < 2; ++side) {
    const Contact::Side& s = contact.sides[side];
    names[side] = s.part == kNoIndex ? short_name(s.object, motions)
                                     : parts_of(s.object, motions, settings).names[s.part];
  }
  return names;
}

Result<std::unique_ptr<ReportWriter>> contacts_csv(const std::string& path, Motions motions,
                                                   const CheckSettings& settings) {
  auto file = FOLDPROOF_TRY(FileWriter::open(path));
  return std::make_unique<ContactsCsv>(std::move(file), motions, settings);
}

}  // namespace foldproof
