/// Sweeps in parts, on any machines, and joining what they wrote (docs/sweep.md).
#pragma once

#include "sweep/sweep.h"

namespace foldproof {

/// One of `count` parts of a sweep. Numbers begin with 1.
struct Shard {
  std::uint32_t number = 1, count = 1;
};

/// "2/4". Error: there is no such shard.
Result<Shard> parse_shard(const std::string& text);
std::string name_of(Shard shard);

/// A path as it is written in a line: the same, unless it is not valid UTF-8.
std::string as_written(const std::string& path);

/// The number of the shard to which a motion belongs. It depends on the motion's path alone, so that a motion
/// that is added moves no other.
std::uint32_t shard_of(const std::string& path, std::uint32_t count);

/// A Hash of paths and sizes, in any order.
std::string hash_of_input(std::vector<std::pair<std::string, std::uint64_t>> motions);

/// The first line of a shard's file. Only `shard` and `motions` differ between files that may be joined.
struct ShardHeader {
  Shard shard;
  std::uint64_t motions = 0;      ///< Number of motions of the shard.
  std::string version, settings;  ///< The library's version; settings_hash.
  std::string input;              ///< hash_of_input of all motions, also those of other shards.
  SweepScope scope;               ///< Without the command.
};

/// Removes the motions of other shards from `input`. `settings`: settings_hash.
ShardHeader take_shard(SweepInput& input, Shard shard, SweepScope scope, const std::string& settings);

/// JSON, without the line end.
std::string line_of(const ShardHeader& header);
/// None: it is another line.
std::optional<ShardHeader> read_shard_header(const std::string& line);

/// What the shards of a sweep found together.
struct JoinedSweep {
  SweepScope scope;
  std::string lines;                 ///< The file that one sweep would have written.
  std::vector<SweepRecord> records;  ///< Of the same lines.
};

/// Error: these are not the files of all shards of one sweep, each once and finished.
Result<JoinedSweep> join_shards(std::span<const std::string> paths);

}  // namespace foldproof
