// Joins the files of shards.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "base/try.h"
#include "io/bytes.h"
#include "io/readers.h"
#include "sweep/shard.h"

namespace foldproof {
namespace {

struct Line {
  std::string text;
  SweepRecord record;
};

struct ShardFile {
  std::string path;
  ShardHeader header;
  std::vector<Line> lines;
};

tl::unexpected<Error> refuse(const std::string& path, std::string problem, std::string remedy) {
  return fail(ErrorCode::InvalidArgument, path, std::move(problem), std::move(remedy));
}

std::string run_again(const ShardHeader& header) {
  return fmt::format("run the sweep with --shard {} again", name_of(header.shard));
}

/// Reads complete lines; what a sweep that was killed wrote of another one is left out.
Result<ShardFile> read_shard(const std::string& path) {
  const std::vector<char> bytes = FOLDPROOF_TRY(io::read_file(path));
  std::string_view text(bytes.data(), bytes.size());
  const auto take_line = [&]() -> std::optional<std::string> {
    const std::size_t end = text.find('\n');
    if (end == text.npos) return std::nullopt;
    std::string line(text.substr(0, end));
    text.remove_prefix(end + 1);
    return line;
  };
  const auto first = take_line();
  const auto header = first ? read_shard_header(*first) : std::nullopt;
  if (!header)
    return refuse(path, "does not hold a shard of a sweep",
                  "name the files that 'sweep --shard' has written");
  ShardFile file{path, *header, {}};
  while (auto line = take_line()) {
    auto record = read_sweep_line(*line);
    if (!record)
      return fail(ErrorCode::InvalidFile, fmt::format("{}:{}", path, file.lines.size() + 2),
                  "is no result of a sweep", "remove the line, and " + run_again(*header));
    file.lines.push_back({std::move(*line), std::move(*record)});
  }
  return file;
}

/// Error: the shards are of two sweeps.
Result<void> require_one_sweep(const ShardFile& first, const ShardFile& file) {
  const ShardHeader &a = first.header, &b = file.header;
  const auto unlike = [&](const std::string& what, const char* remedy) {
    return refuse(file.path, fmt::format("{} '{}'", what, first.path), remedy);
  };
  if (a.shard.count != b.shard.count)
    return unlike(fmt::format("is one of {} shards, not of {} as", b.shard.count, a.shard.count),
                  "name the shards of one sweep");
  if (a.version != b.version)
    return unlike(fmt::format("was made by version {}, not {} as", b.version, a.version),
                  "run all shards again with one version");
  if (a.settings != b.settings)
    return unlike("was made with other settings than", "run all shards again with the same options");
  if (a.input != b.input || a.scope.directories != b.scope.directories)
    return unlike("was made from another list of motions than",
                  "run all shards again; what has not changed is kept");
  return {};
}

/// Error: a shard is missing or doubled.
Result<void> require_each_once(std::span<const ShardFile> files) {
  constexpr std::size_t kMaxShown = 10;
  const std::uint32_t count = files[0].header.shard.count;
  std::vector<const ShardFile*> found(count + std::size_t{1});
  for (const ShardFile& file : files) {
    const ShardFile*& place = found[file.header.shard.number];
    if (place)
      return refuse(file.path,
                    fmt::format("holds shard {}, as does '{}'", name_of(file.header.shard), place->path),
                    "name one of them");
    place = &file;
  }
  std::vector<std::string> missing;
  for (std::uint32_t number = 1; number <= count; ++number) {
    if (!found[number]) missing.push_back(name_of(Shard{number, count}));
  }
  if (missing.empty()) return {};
  const auto shown = std::span(missing).first(std::min(missing.size(), kMaxShown));
  return refuse("--join",
                fmt::format("lacks {} of {} shards: {}{}", missing.size(), count, fmt::join(shown, ", "),
                            shown.size() < missing.size() ? ", ..." : ""),
                "name their files, too");
}

/// Error: the lines are not those of all motions of the shard.
Result<void> require_finished(const ShardFile& file) {
  const ShardHeader& header = file.header;
  std::set<std::pair<std::string, std::string>> paths;  // of names that are not UTF-8, the status differs
  for (const auto& [text, record] : file.lines) {
    if (shard_of(record.path, header.shard.count) != header.shard.number ||
        record.settings != header.settings)
      return refuse(file.path,
                    fmt::format("holds '{}', which does not belong to shard {} or has other settings",
                                record.path, name_of(header.shard)),
                    "remove the line, and " + run_again(header));
    if (!paths.emplace(record.path, record.status).second)
      return refuse(file.path, fmt::format("holds '{}' twice", record.path), run_again(header));
  }
  if (file.lines.size() != header.motions)
    return refuse(
        file.path,
        fmt::format("is not finished: it holds {} of {} motions", file.lines.size(), header.motions),
        run_again(header));
  return {};
}

}  // namespace

Result<JoinedSweep> join_shards(std::span<const std::string> paths) {
  std::vector<ShardFile> files;
  for (const std::string& path : paths) {
    files.push_back(FOLDPROOF_TRY(read_shard(path)));
    FOLDPROOF_TRY(require_one_sweep(files.front(), files.back()));
  }
  FOLDPROOF_TRY(require_each_once(files));
  std::vector<Line> lines;
  std::vector<std::pair<std::string, std::uint64_t>> motions;
  for (ShardFile& file : files) {
    FOLDPROOF_TRY(require_finished(file));
    for (Line& line : file.lines) {
      motions.emplace_back(line.record.path, line.record.bytes);
      lines.push_back(std::move(line));
    }
  }
  if (hash_of_input(std::move(motions)) != files.front().header.input)
    return refuse(files.front().path, "and the others do not hold the motions that they were made from",
                  "run all shards again with --again");
  std::stable_sort(lines.begin(), lines.end(), [](const Line& a, const Line& b) {
    return io::natural_less(a.record.path, b.record.path);
  });
  JoinedSweep joined{files.front().header.scope, {}, {}};
  for (Line& line : lines) {
    joined.lines += line.text + '\n';
    joined.records.push_back(std::move(line.record));
  }
  return joined;
}

}  // namespace foldproof
