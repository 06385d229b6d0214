#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>

#include "base/try.h"
#include "report/report.h"

namespace foldproof {
namespace {

tl::unexpected<Error> bad_range(const std::string& text) {
  return fail(ErrorCode::InvalidArgument, "--frames", fmt::format("'{}' is not A:B or A:B:STEP", text),
              "give whole numbers as in a Python slice, such as 0:10, 5:, :-1 or ::2");
}

/// Parses `part` as a whole number; none when it is empty. `text` is for errors.
Result<std::optional<std::int64_t>> parse_part(std::string_view part, const std::string& text) {
  if (part.empty()) return std::nullopt;
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
  if (error != std::errc() || end != part.data() + part.size()) return bad_range(text);
  return value;
}

/// Python's rule for a bound of a slice.
std::int64_t clamp_bound(std::int64_t end, std::int64_t count) {
  return std::clamp<std::int64_t>(end < 0 ? end + count : end, 0, count);
}

}  // namespace

Result<FrameRange> parse_frame_range(const std::string& text) {
  std::vector<std::optional<std::int64_t>> parts;
  std::string_view rest = text;
  for (;;) {
    const std::size_t colon = rest.find(':');
    const auto part = FOLDPROOF_TRY(parse_part(rest.substr(0, colon), text));
    parts.push_back(part);
    if (colon == std::string_view::npos) break;
    rest.remove_prefix(colon + 1);
  }
  if (parts.size() > 3 || (parts.size() == 1 && !parts[0])) return bad_range(text);

  FrameRange range{.begin = parts[0], .end = {}, .step = 1};
  if (parts.size() == 1) {
    // A single frame. After -1, the last one, and the largest number there is none to name as end.
    if (*range.begin != -1 && *range.begin != std::numeric_limits<std::int64_t>::max())
      range.end = *range.begin + 1;
    return range;
  }
  range.end = parts[1];
  if (parts.size() == 3 && parts[2]) {
    if (*parts[2] < 1 || *parts[2] > 0xffffffffll) {
      return fail(ErrorCode::InvalidArgument, "--frames",
                  fmt::format("the step in '{}' is not 1 or more", text),
                  "motions are checked forward in time");
    }
    range.step = static_cast<Index>(*parts[2]);
  }
  return range;
}

std::vector<Index> select_frames(const FrameRange& range, Index frame_count) {
  const std::int64_t begin = clamp_bound(range.begin.value_or(0), frame_count);
  const std::int64_t end = clamp_bound(range.end.value_or(frame_count), frame_count);
  std::vector<Index> frames;
  for (std::int64_t frame = begin; frame < end; frame += range.step)
    frames.push_back(static_cast<Index>(frame));
  return frames;
}

std::string every_nth_frame(Index n) {
  constexpr std::array kEndings = {"th", "st", "nd", "rd"};
  const bool irregular = n % 10 < 4 && n / 10 % 10 != 1;
  return fmt::format("every {}{} frame", n, kEndings[irregular ? n % 10 : 0]);
}

std::vector<std::string> untested(Motions motions, const CheckSettings& settings, const CheckTotals& totals) {
  std::vector<std::string> sentences;
  if (std::string ignored = ignored_pairs(settings); !ignored.empty())
    sentences.push_back(std::move(ignored));
  if (skips_frames(settings, totals))
    sentences.push_back("only " + every_nth_frame(settings.frames.step) + " was checked");
  if (!settings.step.within) {
    sentences.emplace_back("pairs within one mesh were not tested");
  } else if (!settings.step.between && motions.size() > 1) {
    sentences.emplace_back("pairs of two meshes were not tested");
  }
  for (const auto& motion : motions) {
    for (const std::string& unchecked : motion->info().unchecked)
      sentences.push_back(motions.size() > 1 ? motion->name() + ": " + unchecked : unchecked);
  }
  return sentences;
}

bool skips_frames(const CheckSettings& settings, const CheckTotals& totals) {
  return settings.frames.step > 1 && totals.first_frame != totals.last_frame;
}

}  // namespace foldproof
