#include "page/repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "base/try.h"
#include "io/bytes.h"
#include "io/gltf_repair.h"
#include "io/new_directory.h"
#include "page/page_json.h"
#include "page/repaired_report.h"
#include "report/repair_files.h"
#include "report/repair_report.h"

namespace foldproof {
namespace {

namespace fs = std::filesystem;

Error nothing_repaired() { return {"repair", "has no result", "start it first", ErrorCode::InvalidArgument}; }

}  // namespace

void RepairService::start(RepairChoice choice) {
  const std::lock_guard lock(mutex_);
  cancelled_ = true;  // the one that is being computed, until the next one begins
  state_ = State::Queued;
  progress_ = 0;
  choice_ = std::move(choice);
  error_.clear();
  done_.reset();
}

void RepairService::cancel() {
  const std::lock_guard lock(mutex_);
  cancelled_ = true;
  if (state_ == State::Queued || state_ == State::Running) state_ = State::Idle;
}

Json RepairService::status() const {
  constexpr std::array<const char*, 5> kStates{"idle", "queued", "running", "done", "failed"};
  const std::lock_guard lock(mutex_);
  Json json = {
      {"state", kStates[static_cast<std::size_t>(state_)]}, {"progress", progress_}, {"error", error_}};
  if (!done_) return json;
  const RepairReport& report = done_->motions.report;
  json.update(repair_json(scene_.motions(), done_->request, report));
  Json& files = json["files"] = Json::array();
  if (!report.written || report.unchanged) return json;
  for (std::size_t i = 0; i < done_->files.size(); ++i) {
    if (done_->moved[i]) files.push_back({{"object", done_->motions.movable[i]}, {"name", done_->files[i]}});
  }
  return json;
}

bool RepairService::compute_queued(const std::atomic<bool>& stop) {
  std::unique_lock lock(mutex_);
  if (state_ != State::Queued) return false;
  state_ = State::Running;
  cancelled_ = false;
  const RepairChoice choice = choice_;
  lock.unlock();
  Result<Repaired> done = tl::unexpected(nothing_repaired());
  try {
    done = compute(choice, stop);
  } catch (const std::exception& error) {
    done = tl::unexpected(Error{"repair", line_of(error), "", ErrorCode::LimitExceeded});
  }
  lock.lock();
  if (state_ != State::Running) return true;  // it was cancelled, or is to begin again
  state_ = done ? State::Done : State::Failed;
  if (done) {
    done_ = std::make_shared<const Repaired>(std::move(*done));
  } else {
    error_ = done.error().line();
  }
  return true;
}

Result<RepairService::Repaired> RepairService::compute(const RepairChoice& choice,
                                                       const std::atomic<bool>& stop) {
  if (scene_.settings().poses)
    return fail(ErrorCode::InvalidArgument, "--static",
                "checks frames one by one, and a repair is of a motion", "start without it");
  RepairRequest request{scene_.settings(), {}, {}, {}};
  request.check.step.explain = false;
  for (const Index object : choice.fixed) request.fixed.push_back(scene_.motions()[object]->name());
  for (const ScenePart& part : choice.fixed_parts)
    request.fixed.push_back(scene_.motions()[part.object]->name() + ":" + scene_.part_name(part));
  request.fixed_vertices = choice.fixed_vertices;
  if (choice.contact) request.repair.chosen = in_group_of(*choice.contact);
  request.repair.interrupted = [&] { return stop || cancelled_; };
  request.repair.progress = [this](double share) {
    if (context_.progress) context_.progress(share);
    const std::lock_guard lock(mutex_);
    progress_ = share;
  };
  if (FOLDPROOF_TRY(movable_objects(scene_.motions(), request)).empty())
    return fail(ErrorCode::InvalidArgument, "repair", "has nothing that may move", "let an object move");
  auto motions = FOLDPROOF_TRY(repair_motions(scene_.motions(), request));
  request.repair.interrupted = nullptr;
  request.repair.progress = nullptr;
  std::vector<std::string> files;
  for (const Index object : motions.movable) files.push_back(file_name(object));
  auto moved = FOLDPROOF_TRY(this->moved(motions));
  return Repaired{std::move(request), std::move(motions), std::move(files), std::move(moved)};
}

Result<std::vector<bool>> RepairService::moved(const RepairedMotions& motions) const {
  std::vector<bool> moved(motions.movable.size(), false);
  if (!motions.report.written || motions.report.unchanged) return moved;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const Index object = motions.movable[i];
    const auto after = motions.motion(object);
    std::vector<double> x(3 * std::size_t{after->topology().vertex_count()});
    for (Index k = 0; k < after->frame_count() && !moved[i]; ++k) {
      FOLDPROOF_TRY(after->read_frame(k, x));
      moved[i] = x != *FOLDPROOF_TRY(scene_.frame(object, k));
    }
  }
  return moved;
}

Result<std::shared_ptr<const RepairService::Repaired>> RepairService::done() const {
  const std::lock_guard lock(mutex_);
  if (done_) return done_;
  return tl::unexpected(nothing_repaired());
}

Result<std::shared_ptr<const RepairService::Repaired>> RepairService::repaired(Index object) const {
  auto done = FOLDPROOF_TRY(this->done());
  if (done->motions.report.written && object < scene_.objects().size()) return done;
  return tl::unexpected(nothing_repaired());
}

Result<std::vector<double>> RepairService::frame(Index object, Index k) const {
  const auto done = FOLDPROOF_TRY(repaired(object));
  const auto motion = done->motions.motion(object);
  if (k >= motion->frame_count()) return tl::unexpected(nothing_repaired());
  std::vector<double> x(3 * std::size_t{motion->topology().vertex_count()});
  FOLDPROOF_TRY(motion->read_frame(k, x));
  return x;
}

std::string RepairService::file_name(Index object) const {
  const std::string& source = scene_.motions()[object]->name();
  const std::string stem = fs::path(source).stem().generic_string() + "-repaired";
  const bool still = scene_.motions()[object]->frame_count() == 1 && scene_.frames().size() > 1;
  const bool glb = !still && io::require_gltf_can_be_repaired(stem + ".glb", source).has_value();
  return stem + (glb ? ".glb" : ".npz");
}

Result<std::string> RepairService::file(Index object) const {
  const auto done = FOLDPROOF_TRY(repaired(object));
  const auto directory =
      FOLDPROOF_TRY(io::NewDirectory::open(fs::temp_directory_path() / "foldproof-repair"));
  RepairOutputs outputs{{}, scene_.read(), 0};
  std::string path;
  for (std::size_t i = 0; i < done->files.size(); ++i) {
    const Index each = done->motions.movable[i];
    outputs.paths.push_back((directory.path() / fmt::format("{}-{}", each, done->files[i])).generic_string());
    if (each == object) path = outputs.paths.back();
  }
  if (path.empty()) return tl::unexpected(nothing_repaired());
  FOLDPROOF_TRY(write_outputs(outputs, scene_.motions(), done->request, done->motions));
  const auto bytes = FOLDPROOF_TRY(io::read_file(path));
  return std::string(bytes.begin(), bytes.end());
}

Result<Json> RepairService::contacts(std::uint64_t offset, std::uint64_t limit) const {
  const auto done = FOLDPROOF_TRY(this->done());
  const RepairReport& report = done->motions.report;
  Json items = Json::array();
  std::uint64_t k = 0;
  for (const auto* list : {&report.remaining, &report.left}) {
    const auto contacts = contact_totals(*list, report).contacts;
    const auto groups = groups_of(contacts);
    for (std::size_t i = 0; i < contacts.size(); ++i, ++k) {
      if (k < offset || k - offset >= limit) continue;
      const auto names = side_names(contacts[i], scene_.motions(), scene_.settings());
      items.push_back(contact_json(contacts[i], names, groups[i], true));
    }
  }
  return Json{{"total", k}, {"items", std::move(items)}};
}

Result<std::string> RepairService::report() const {
  const auto done = FOLDPROOF_TRY(this->done());
  const auto directory =
      FOLDPROOF_TRY(io::NewDirectory::open(fs::temp_directory_path() / "foldproof-report"));
  const std::string path = (directory.path() / "report.html").generic_string();
  FOLDPROOF_TRY(write_repaired_report(path, scene_.motions(), done->request, done->motions, context_.command,
                                      context_.files));
  std::ifstream file(path, std::ios::binary);  // readers of motions refuse HTML
  std::string html{std::istreambuf_iterator<char>(file), {}};
  if (!html.empty()) return html;
  return fail(ErrorCode::FileAccess, "temporary file", "cannot be read", "look whether the disk is full");
}

}  // namespace foldproof
