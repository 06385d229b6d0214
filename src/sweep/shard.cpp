// Which motions belong to a shard, and the first line of its file.
#include "sweep/shard.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "report/json_values.h"

namespace foldproof {
namespace {

constexpr std::uint32_t kMaxShards = 1'000'000;

bool exists(Shard shard) {
  return shard.number >= 1 && shard.number <= shard.count && shard.count <= kMaxShards;
}

}  // namespace

Result<Shard> parse_shard(const std::string& text) {
  Shard shard;
  const char* end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), end, shard.number);
  if (number.ec == std::errc() && number.ptr != end && *number.ptr == '/') {
    const auto count = std::from_chars(number.ptr + 1, end, shard.count);
    if (count.ec == std::errc() && count.ptr == end && exists(shard)) return shard;
  }
  return fail(ErrorCode::InvalidArgument, "--shard", fmt::format("'{}' is no shard", text),
              fmt::format("give I/N with I from 1 to N, and N up to {}; add 1 to an I that counts from 0",
                          kMaxShards));
}

std::string name_of(Shard shard) { return fmt::format("{}/{}", shard.number, shard.count); }

std::string as_written(const std::string& path) { return Json::parse(dump(path)).get<std::string>(); }

std::uint32_t shard_of(const std::string& path, std::uint32_t count) {
  Hash hash;
  hash.add(as_written(path));
  // Folded, as the low bits of FNV-1a depend on the low bits of characters only: two shards would leave one
  // without any of walk/walk.glb, run/run.glb and so on.
  const auto folded = static_cast<std::uint32_t>(hash.value() >> 32 ^ hash.value());
  return folded % count + 1;
}

std::string hash_of_input(std::vector<std::pair<std::string, std::uint64_t>> motions) {
  std::sort(motions.begin(), motions.end());
  Hash hash;
  for (const auto& [path, bytes] : motions) hash.add(fmt::format("{}\n{}\n", path, bytes));
  return hash.text();
}

ShardHeader take_shard(SweepInput& input, Shard shard, SweepScope scope, const std::string& settings) {
  std::vector<std::pair<std::string, std::uint64_t>> all;
  for (const SweepMotion& motion : input.motions) all.emplace_back(as_written(motion.path), motion.bytes);
  std::erase_if(input.motions, [&](const SweepMotion& motion) {
    return shard_of(motion.path, shard.count) != shard.number;
  });
  for (std::string& directory : scope.directories) directory = as_written(directory);
  return {shard, input.motions.size(), version(), settings, hash_of_input(std::move(all)), std::move(scope)};
}

std::string line_of(const ShardHeader& header) {
  const SweepScope& scope = header.scope;
  return dump({{"shard", header.shard.number},
               {"of", header.shard.count},
               {"motions", header.motions},
               {"version", header.version},
               {"settings", header.settings},
               {"input", header.input},
               {"directories", scope.directories},
               {"single_meshes", scope.single_meshes},
               {"single_arrays", scope.single_arrays},
               {"static", scope.poses},
               {"steps_only", scope.steps_only},
               {"frames", scope.frames},
               {"ignore", scope.ignore}});
}

std::optional<ShardHeader> read_shard_header(const std::string& line) {
  try {
    const Json json = Json::parse(line);
    ShardHeader header;
    json.at("shard").get_to(header.shard.number);
    json.at("of").get_to(header.shard.count);
    json.at("motions").get_to(header.motions);
    json.at("version").get_to(header.version);
    json.at("settings").get_to(header.settings);
    json.at("input").get_to(header.input);
    json.at("directories").get_to(header.scope.directories);
    json.at("single_meshes").get_to(header.scope.single_meshes);
    json.at("single_arrays").get_to(header.scope.single_arrays);
    json.at("static").get_to(header.scope.poses);
    json.at("steps_only").get_to(header.scope.steps_only);
    json.at("frames").get_to(header.scope.frames);
    json.at("ignore").get_to(header.scope.ignore);
    if (exists(header.shard)) return header;
  } catch (const Json::exception&) {  // another line
  }
  return std::nullopt;
}

}  // namespace foldproof
