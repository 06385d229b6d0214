// Checks a motion and converts the result to a line of JSON, and back.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <new>

#include "base/try.h"
#include "io/formats.h"
#include "io/numbered.h"
#include "report/contact_pictures.h"
#include "report/ignored.h"
#include "report/json_values.h"
#include "report/repair_files.h"
#include "report/repair_report.h"
#include "sweep/sweep.h"
#include "system/c_locale.h"

namespace foldproof {
namespace {

// Per step; contacts need pairs, and more than these would cost more than the check. contacts_cut() says it.
constexpr std::uint64_t kMaxListed = 1'000'000;
// Raise it with every change after which an answer may differ: lines of other revisions are checked again.
constexpr int kAnswerRevision = 3;
constexpr ContactPictures::Format kThumbnail{160, 120, false};

Result<std::unique_ptr<Motion>> open_motion(const SweepMotion& motion, const ReadOptions& options) {
  const bool frames = motion.files.size() > 1 && io::is_kind(motion.files.back(), io::FileKind::Mesh);
  if (!frames) {
    ReadOptions read = options;
    if (!extension_of(motion.files[0]).starts_with(".gl")) read.clip.clear();  // others have none
    auto opened = FOLDPROOF_TRY(open_motions(motion.files, read));
    return std::move(opened.front());
  }
  auto opened = FOLDPROOF_TRY(io::open_numbered(motion.path, motion.files, {}));
  if (options.mesh_files == MeshFiles::ByName) FOLDPROOF_TRY(io::require_frames(*opened, motion.files));
  if (options.weld == Weld::Always) opened = FOLDPROOF_TRY(io::weld(std::move(opened)));
  opened = FOLDPROOF_TRY(io::with_loose_vertices(std::move(opened), options.points));
  return opened;
}

Json head_of(const SweepMotion& motion, const SweepSettings& settings) {
  return {{"path", motion.path},
          {"state", nullptr},
          {"settings", settings_hash(settings)},
          {"bytes", motion.bytes},
          {"modified", motion.modified},
          {"status", motion.status},
          {"seconds", 0.0}};
}

void set_failed(Json& line, const Error& error) {
  line["state"] = name_of(error.code == ErrorCode::Ambiguous ? SweepState::Unclear : SweepState::Failed);
  line["error"] = error.line();
}

/// The worst contact, or the first frame. Without it, a line is complete, too.
void add_thumbnail(Json& line, Motions motions, const CheckSettings& settings, const CheckTotals& totals) {
  auto pictures = ContactPictures::open(motions, settings);
  if (!pictures) return;
  const auto png = totals.contacts.empty() ? pictures->draw_first_frame(kThumbnail)
                                           : pictures->draw(totals.contacts.front(), kThumbnail);
  if (png) line["thumbnail"] = data_url(*png);
}

/// Where a motion is written when it is repaired: in the directory, below its own path, whose ".." are left
/// out.
std::filesystem::path repaired_path(const std::string& directory, const SweepMotion& motion, bool is_gltf) {
  std::filesystem::path path = directory;
  for (const auto& part : std::filesystem::path(motion.path).relative_path()) {
    if (part != ".." && part != ".") path /= part;
  }
  const std::string ending = is_gltf ? ".glb" : ".npz";
  if (extension_of(path.generic_string()) != ending) path += ending;
  return path;
}

/// Repairs a motion and writes it. Error: it cannot be, or it was interrupted.
Result<void> repair_into(Json& line, const SweepMotion& found, Motions motions, const SweepSettings& settings,
                         const CheckSettings& check, const CheckHooks& hooks) {
  RepairRequest request{check, {}, {}, {}};
  request.check.step.max_listed = settings.check.step.max_listed;
  if (hooks.cancel != nullptr) request.repair.interrupted = [&] { return hooks.cancel->load(); };
  const bool is_gltf = extension_of(found.files[0]).starts_with(".gl");
  const auto path = repaired_path(settings.repaired, found, is_gltf);
  const RepairOutputs outputs{{path.generic_string()}, settings.read, 0};
  FOLDPROOF_TRY(require_outputs_fit(outputs, motions, std::array{Index{0}}, motions[0]->frame_count()));
  const auto done = FOLDPROOF_TRY(repair_motions(motions, request));
  const RepairReport& report = done.report;
  const bool writes = report.written && !report.unchanged;
  if (writes) {
    std::error_code code;
    std::filesystem::create_directories(path.parent_path(), code);
    FOLDPROOF_TRY(write_outputs(outputs, motions, request, done));
  }
  const auto worst = std::ranges::max_element(report.frames, {}, &RepairedFrame::correction);
  line["repair"] = {{"file", writes ? Json(path.generic_string()) : Json(nullptr)},
                    {"free", report.free},
                    {"verdict", repair_verdict(motions, request, report).sentence.text()},
                    {"correction", worst->correction}};
  return {};
}

/// Checks a motion and adds the results to `line`. False if the check was cancelled.
Result<bool> check_into(Json& line, const SweepMotion& found, const SweepSettings& settings,
                        const CheckHooks& hooks) {
  auto motion = FOLDPROOF_TRY(open_motion(found, settings.read));
  const Topology& topology = motion->topology();
  const auto model = std::find_if(settings.models.begin(), settings.models.end(),
                                  [&](const auto& m) { return m->hierarchy()->topology() == topology; });
  CheckSettings check = settings.check;
  check.step.max_listed = kMaxListed;
  check.ignore = known_pairs(std::span(&motion, 1), check);  // others are of other motions
  if (model != settings.models.end()) check.models = {*model};
  const Json object = objects_json(std::span(&motion, 1), check)[0];
  for (const char* key : {"vertices", "triangles", "frames", "merged", "model"}) line[key] = object[key];
  line["frames_checked"] = settings_json({check, settings.read}, std::span(&motion, 1))["frames"];
  for (const char* key : {"lines", "points", "notes", "unchecked"}) {
    if (object.contains(key)) line[key] = object[key];
  }
  if (!check.ignore.empty()) line["ignored"] = check.ignore;
  if (!check.poses && check.steps_only && motion->frame_count() == 1) {
    line["state"] = name_of(SweepState::Still);
    return true;
  }
  const auto totals = FOLDPROOF_TRY(run_check(std::span(&motion, 1), check, {}, hooks));
  line["state"] = name_of(totals.clean() ? SweepState::Clean : SweepState::Collides);
  line["verdict"] = verdict(std::span(&motion, 1), check, totals).sentence.text();
  line["totals"] = totals_json(totals, check.poses, false);
  for (const auto& notice : totals.notices) line["notes"].push_back(notice.text);
  if (!totals.cancelled) add_thumbnail(line, std::span(&motion, 1), check, totals);
  if (!totals.cancelled && !totals.clean() && !settings.repaired.empty()) {
    const auto done = repair_into(line, found, std::span(&motion, 1), settings, check, hooks);
    if (!done && done.error().code == ErrorCode::Interrupted) return false;
    if (!done) line["repair"] = {{"file", nullptr}, {"free", false}, {"verdict", done.error().line()}};
  }
  return !totals.cancelled;
}

Result<SweepState> state_of(const std::string& name) {
  for (const SweepState state : {SweepState::Clean, SweepState::Collides, SweepState::Failed,
                                 SweepState::Unclear, SweepState::Still}) {
    if (name == name_of(state)) return state;
  }
  return fail(ErrorCode::InvalidFile, name, "is no state", "remove the line");
}

/// Reads the fields of a checked motion.
void read_totals(const Json& totals, SweepRecord& record) {
  totals.at("steps").get_to(record.steps);
  totals.at("steps_with_collisions").get_to(record.steps_with_collisions);
  for (const auto& [kind, count] : totals.at("collisions").items())
    record.collisions += count.get<std::uint64_t>();
  const auto frame = [&](const char* key) -> std::optional<std::uint64_t> {
    const Json& step = totals.at(key);
    if (step.is_null()) return std::nullopt;
    return step.at("frame").get<std::uint64_t>();
  };
  // Lines of older versions lack it.
  if (totals.contains("starts_crossing") && !totals.at("starts_crossing").is_null())
    record.starts_crossing = totals.at("starts_crossing").get<std::uint64_t>();
  if (totals.contains("contacts")) {
    const Json& contacts = totals.at("contacts");
    record.contacts = contacts.at("count").get<std::uint64_t>();
    if (!contacts.at("depth").is_null()) record.depth = contacts.at("depth").get<double>();
    // With steps_only frames are unknown for another reason.
    record.contacts_cut =
        totals.contains("listed") || (record.starts_crossing && contacts.value("unknown_frames", 0) > 0);
  }
  record.first_frame = frame("earliest");
  record.worst_frame = frame("worst");
}

}  // namespace

const char* name_of(SweepState state) {
  switch (state) {
    case SweepState::Clean:
      return "clean";
    case SweepState::Collides:
      return "collides";
    case SweepState::Still:
      return "still";
    case SweepState::Unclear:
      return "unclear";
    case SweepState::Failed:
      break;
  }
  return "failed";
}

std::string Hash::text() const { return fmt::format("{:016x}", value_); }

std::string settings_hash(const SweepSettings& settings) {
  const CheckSettings& check = settings.check;
  const auto end = [](const std::optional<std::int64_t>& e) { return e ? Json(*e) : Json(nullptr); };
  Json all = {{"version", version()},
              {"revision", kAnswerRevision},
              {"static", check.poses},
              {"start", !check.poses && !check.steps_only},
              {"contacts", true},
              {"frames", {end(check.frames.begin), end(check.frames.end), check.frames.step}},
              {"substeps", check.substeps},
              {"thickness", check.step.thickness},
              {"tolerance", check.step.tolerance},
              {"seams", name_of(settings.read.weld)},
              {"points", settings.read.points},
              {"fps", settings.read.fps}};
  if (!settings.read.clip.empty()) all["clip"] = settings.read.clip;
  if (!settings.repaired.empty()) all["repair"] = settings.repaired;
  Hash hash;
  hash.add(dump(all));
  if (!check.ignore.empty()) hash.add(dump(Json(check.ignore)));
  return hash.text();
}

std::optional<std::string> sweep_line(const SweepMotion& motion, const SweepSettings& settings,
                                      const CheckHooks& hooks) {
  const auto start = std::chrono::steady_clock::now();
  Json line = head_of(motion, settings);
  try {
    const auto done = check_into(line, motion, settings, hooks);
    if (done && !*done) return std::nullopt;
    if (!done) set_failed(line, done.error());
  } catch (const std::bad_alloc&) {
    set_failed(line, {motion.path, "does not fit into memory", "use a smaller mesh or a larger machine"});
  }
  line["seconds"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return dump(line);
}

std::string contacts_cut(std::span<const SweepRecord> records) {
  static_assert(kMaxListed == 1'000'000);
  const auto cut =
      std::count_if(records.begin(), records.end(), [](const auto& r) { return r.contacts_cut; });
  if (cut == 0) return "";
  return fmt::format("leave out pairs in {} motion{}: more than a million of a kind in a step or frame", cut,
                     cut == 1 ? "" : "s");
}

Result<SweepRecord> read_sweep_line(const std::string& line) {
  const CLocale numbers;
  try {
    const Json json = Json::parse(line);
    SweepRecord record;
    json.at("path").get_to(record.path);
    json.at("settings").get_to(record.settings);
    record.status = json.value("status", "");  // a line without it is checked again
    json.at("bytes").get_to(record.bytes);
    json.at("modified").get_to(record.modified);
    json.at("seconds").get_to(record.seconds);
    record.state = FOLDPROOF_TRY(state_of(json.at("state").get<std::string>()));
    if (json.contains("error")) json.at("error").get_to(record.error);
    if (json.contains("notes")) json.at("notes").get_to(record.notes);
    if (json.contains("ignored")) json.at("ignored").get_to(record.ignored);
    for (const Json& unchecked : json.value("unchecked", Json::array()))
      record.notes.push_back(unchecked.get<std::string>());
    if (json.contains("vertices")) {
      json.at("vertices").get_to(record.vertices);
      json.at("triangles").get_to(record.triangles);
      json.at("frames").get_to(record.frames);
      if (!json.at("model").is_null()) json.at("model").get_to(record.model);
    }
    if (json.contains("verdict")) json.at("verdict").get_to(record.verdict);
    if (json.contains("repair")) record.repair = json.at("repair").at("verdict").get<std::string>();
    if (json.contains("thumbnail")) json.at("thumbnail").get_to(record.thumbnail);
    if (json.contains("totals")) read_totals(json.at("totals"), record);
    return record;
  } catch (const Json::exception&) {
    return fail(ErrorCode::InvalidFile, "the line", "is no result of a sweep", "name another file");
  }
}

}  // namespace foldproof
