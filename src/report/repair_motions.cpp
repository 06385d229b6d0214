#include "report/repair_motions.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "base/try.h"
#include "io/spool.h"
#include "report/contact_groups.h"
#include "report/ignored.h"

namespace foldproof {

/// The frames of all objects, one after the other.
struct RepairedMotions::Store {
  io::Spool frames;
  std::vector<std::string> names;
  std::vector<Topology> topologies;
  std::vector<std::size_t> begin;  // first number of each object in a frame, and an end
  Index count = 0;
};

namespace {

/// An object of the store.
class StoredMotion final : public Motion {
 public:
  StoredMotion(std::shared_ptr<const void> owner, const std::string& name, const Topology& topology,
               Index count, std::function<bool(Index, std::span<double>)> read)
      : owner_(std::move(owner)), name_(name), topology_(topology), count_(count), read_(std::move(read)) {}
  const std::string& name() const override { return name_; }
  const Topology& topology() const override { return topology_; }
  Index frame_count() const override { return count_; }
  Result<void> read_frame(Index k, std::span<double> out) override {
    if (read_(k, out)) return {};
    return fail(ErrorCode::FileAccess, "temporary file", "cannot be read", "look whether the disk is full");
  }

 private:
  std::shared_ptr<const void> owner_;  // of what is referred to
  const std::string& name_;
  const Topology& topology_;
  Index count_;
  std::function<bool(Index, std::span<double>)> read_;
};

// Per object and vertex, whether it may move: those of which a triangle is to, and none may not; with them
// those that were merged into them.
Result<std::vector<std::vector<std::uint8_t>>> movable_vertices(Motions motions,
                                                                const RepairRequest& request) {
  const auto fixed = FOLDPROOF_TRY(triangles_named(motions, request.check, request.fixed));
  const auto only = FOLDPROOF_TRY(triangles_named(motions, request.check, request.only));
  if (!request.fixed_vertices.empty() && request.fixed_vertices.size() != motions.size())
    return fail(ErrorCode::InvalidArgument, "fixed_vertices",
                fmt::format("has {} lists for {} objects", request.fixed_vertices.size(), motions.size()),
                "give one for each object");
  std::vector<std::vector<std::uint8_t>> movable;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Topology& topology = motions[i]->topology();
    auto& of = movable.emplace_back(topology.vertex_count(), 0);
    for (std::size_t t = 0; t < topology.triangles().size(); ++t) {
      for (const Index v : topology.triangles()[t]) of[v] |= request.only.empty() || only[i][t] != 0;
    }
    for (std::size_t t = 0; t < topology.triangles().size(); ++t) {
      for (const Index v : topology.triangles()[t]) of[v] &= fixed[i][t] == 0;
    }
    const auto& merged = motions[i]->info().merged;
    const auto one = [&](Index v) { return merged.empty() ? v : merged[v]; };
    if (!request.fixed_vertices.empty()) {
      for (const Index v : request.fixed_vertices[i]) {
        if (v >= of.size())
          return fail(ErrorCode::InvalidArgument, "fixed_vertices",
                      fmt::format("names vertex {} of {}, which has {}", v, motions[i]->name(), of.size()),
                      "count them from 0");
        of[one(v)] = 0;
      }
    }
    for (Index v = 0; v < of.size(); ++v) of[v] = of[one(v)];
  }
  return movable;
}

Result<std::vector<Index>> consecutive_frames(Motions motions, const CheckSettings& settings) {
  auto frames = FOLDPROOF_TRY(frames_to_check(motions, settings));
  for (std::size_t k = 1; k < frames.size(); ++k) {
    if (frames[k] != frames[k - 1] + 1)
      return fail(ErrorCode::InvalidArgument, "--frames", "leaves out frames between others",
                  "select frames that follow each other");
  }
  return frames;
}

// Those of which something may move.
std::vector<Index> objects_of(const std::vector<std::vector<std::uint8_t>>& movable) {
  std::vector<Index> objects;
  for (Index i = 0; i < movable.size(); ++i) {
    if (std::ranges::any_of(movable[i], [](std::uint8_t m) { return m != 0; })) objects.push_back(i);
  }
  return objects;
}

constexpr std::size_t kKnownPoses = 8;  // of an object, where the repair may start

// Moves and turns a pose so that it lies over the frame. Returns the sum of squared distances that remain.
double lay_over(Eigen::VectorXd& pose, std::span<const double> frame) {
  const auto count = static_cast<Eigen::Index>(frame.size() / 3);
  const Eigen::Map<const Eigen::Matrix3Xd> to(frame.data(), 3, count);
  Eigen::Map<Eigen::Matrix3Xd> x(pose.data(), 3, count);
  const Eigen::Matrix4d rigid = Eigen::umeyama(x, to, false);
  x = ((rigid.topLeftCorner<3, 3>() * x).colwise() + rigid.topRightCorner<3, 1>()).eval();
  return (x - to).squaredNorm();
}

// The training poses that are nearest to the frame, laid over it; as the model's subspace has them.
std::vector<Eigen::VectorXd> nearest_poses(const Model& model, std::span<const double> frame) {
  const Predictor predictor(model.learned);
  std::vector<std::pair<double, Eigen::Index>> order;
  for (Eigen::Index k = 0; k < model.learned->coordinates.cols(); ++k) {
    Eigen::VectorXd x = predictor.from_coordinates(model.learned->coordinates.col(k));
    order.emplace_back(lay_over(x, frame), k);
  }
  std::ranges::sort(order);
  order.resize(std::min(order.size(), kKnownPoses));
  std::vector<Eigen::VectorXd> poses;
  for (const auto& [distance, k] : order) {
    lay_over(poses.emplace_back(predictor.from_coordinates(model.learned->coordinates.col(k))), frame);
  }
  return poses;
}

// Poses of all objects, whose numbers in a frame start at `begin`, from their models; an object without one
// is as in the first frame.
Result<std::vector<std::vector<double>>> known_poses(std::span<const std::shared_ptr<const Model>> models,
                                                     std::span<const std::size_t> begin,
                                                     const RepairInput& input) {
  std::vector<double> frame(begin.back());
  FOLDPROOF_TRY(input.read(0, frame));
  std::vector<std::vector<double>> poses(kKnownPoses, frame);
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (!models[i]) continue;
    const auto known = nearest_poses(*models[i], std::span(frame).subspan(begin[i], begin[i + 1] - begin[i]));
    for (std::size_t k = 0; k < poses.size(); ++k)
      std::ranges::copy(known[std::min(k, known.size() - 1)], &poses[k][begin[i]]);
  }
  return poses;
}

// Times count from the first frame that was selected.
void number_by_input(RepairReport& report, Index first) {
  for (RepairedFrame& frame : report.frames) frame.time += first;
  for (auto* contacts : {&report.before, &report.remaining, &report.left, &report.among_fixed}) {
    for (Contact& contact : *contacts) {
      contact.first_time += first;
      contact.last_time += first;
      for (ContactFrame& frame : contact.frames) frame.time += first;
    }
  }
}

}  // namespace

Result<std::vector<Index>> movable_objects(Motions motions, const RepairRequest& request) {
  return objects_of(FOLDPROOF_TRY(movable_vertices(motions, request)));
}

std::function<bool(const Contact&)> in_group_of(const Contact& worst) {
  return [worst](const Contact& contact) { return group_contacts(std::array{worst, contact}).size() == 1; };
}

std::unique_ptr<Motion> RepairedMotions::motion(Index object) const {
  const Store* store = store_.get();
  const std::size_t begin = store->begin[object], size = store->begin.back();
  const auto read = [store, begin, size](Index k, std::span<double> out) {
    const std::uint64_t offset = (k * std::uint64_t{size} + begin) * sizeof(double);
    return store->frames.read_at(offset, {reinterpret_cast<char*>(out.data()), out.size_bytes()});
  };
  return std::make_unique<StoredMotion>(store_, store->names[object], store->topologies[object], store->count,
                                        read);
}

Result<RepairedMotions> repair_motions(Motions motions, const RepairRequest& request) {
  const auto frames = FOLDPROOF_TRY(consecutive_frames(motions, request.check));
  const auto movable = FOLDPROOF_TRY(movable_vertices(motions, request));
  FOLDPROOF_TRY(require_models_of(motions, request.check));
  for (const auto& model : request.check.models) {
    if (model) FOLDPROOF_TRY(require_learned(*model));
  }
  RepairedMotions out;
  out.movable = objects_of(movable);
  out.store_ = std::make_shared<RepairedMotions::Store>(
      RepairedMotions::Store{FOLDPROOF_TRY(io::Spool::open("repair")), {}, {}, {0}, 0});
  RepairedMotions::Store& store = *out.store_;
  RepairInput input;
  input.first_frame = frames[0];
  input.frame_count = static_cast<Index>(frames.size());
  for (Index i = 0; i < motions.size(); ++i) {
    Motion& motion = *motions[i];
    std::vector<double> first(3 * std::size_t{motion.topology().vertex_count()});
    FOLDPROOF_TRY(motion.read_frame(motion.frame_count() == 1 ? 0 : frames[0], first));
    Object object(FOLDPROOF_TRY(Hierarchy::build(motion.topology(), first)));
    object.set_layered(motion.info().layered);
    input.objects.push_back({std::move(object), movable[i], motion.info().merged, motion.name()});
    input.parts.push_back(parts_of(i, motions, request.check).of_triangle);
    store.names.push_back(motion.name());
    store.topologies.push_back(motion.topology());
    store.begin.push_back(store.begin.back() + first.size());
  }
  input.read = [&](Index k, std::span<double> x) -> Result<void> {
    for (std::size_t i = 0; i < motions.size(); ++i) {
      const Index frame = motions[i]->frame_count() == 1 ? 0 : frames[k];
      FOLDPROOF_TRY(
          motions[i]->read_frame(frame, x.subspan(store.begin[i], store.begin[i + 1] - store.begin[i])));
    }
    return {};
  };
  std::vector<Object> objects;
  for (const RepairObject& object : input.objects) objects.push_back(object.object);
  input.filter = FOLDPROOF_TRY(filter_for(motions, request.check, objects, {}, TestedPairs::All));
  RepairSettings settings = request.repair;
  settings.thickness = request.check.step.thickness;
  if (!request.between.empty())
    settings.chosen = FOLDPROOF_TRY(contacts_between(motions, request.check, request.between));
  out.chosen = settings.chosen;
  if (!request.check.models.empty())
    settings.poses = [&] { return known_poses(request.check.models, store.begin, input); };
  out.report = FOLDPROOF_TRY(repair(input, settings, [&](double, std::span<const double> x) -> Result<void> {
    ++store.count;
    return store.frames.append({reinterpret_cast<const char*>(x.data()), x.size_bytes()});
  }));
  number_by_input(out.report, frames[0]);
  return out;
}

}  // namespace foldproof
