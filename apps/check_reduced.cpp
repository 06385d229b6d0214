#include "check_reduced.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>

#include "base/try.h"
#include "commands.h"
#include "foldproof/reduced.h"
#include "options.h"
#include "report/report.h"
#include "terminal.h"

namespace foldproof {
namespace {

// One object's coordinates and placements, frame by frame.
struct Track {
  Index frames = 0, modes = 0;
  std::vector<double> p;  // frames x modes
  std::vector<Eigen::Matrix3d> rotation;
  std::vector<Vec3> translation;

  ReducedPose pose(Index frame) const {
    return {std::span(p).subspan(std::size_t{frame} * modes, modes), rotation[frame], translation[frame]};
  }
};

Result<void> wrong_columns(const std::string& path, std::uint64_t columns, Index modes) {
  return fail(path, fmt::format("has {} columns", columns),
              fmt::format("give {0}, one per mode, or {1} with a placement behind them", modes, modes + 7));
}

// p, then optionally a quaternion w x y z and a translation x y z per row.
Result<Track> from_csv(const std::string& path, Index modes) {
  const auto table = FOLDPROOF_TRY(read_csv(path));
  const std::uint64_t columns = table.shape[1];
  if (columns != modes && columns != modes + 7)
    return tl::unexpected(wrong_columns(path, columns, modes).error());
  Track track{static_cast<Index>(table.shape[0]), modes, {}, {}, {}};
  for (Index k = 0; k < track.frames; ++k) {
    const double* row = &table.values[k * columns];
    track.p.insert(track.p.end(), row, row + modes);
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Vec3 translation = Vec3::Zero();
    if (columns > modes) {
      const double* q = row + modes;
      const Eigen::Quaternion<double> turn(q[0], q[1], q[2], q[3]);
      if (!(turn.norm() > 0)) return fail(path, fmt::format("row {} has no quaternion", k), "give w x y z");
      rotation = turn.normalized().toRotationMatrix();
      translation = {q[4], q[5], q[6]};
    }
    track.rotation.push_back(rotation);
    track.translation.push_back(translation);
  }
  return track;
}

Result<Track> from_tracks(const std::string& path, const Learned& learned) {
  const auto tracks = FOLDPROOF_TRY(read_key_point_tracks(path, learned.key_points.vertices));
  const KeyPointMap map(learned.pca, learned.key_points.vertices);
  Track track{tracks.frames, learned.pca.modes(), {}, {}, {}};
  const std::size_t width = std::size_t{tracks.points} * 3;
  for (Index k = 0; k < track.frames; ++k) {
    const Eigen::VectorXd p = map.coordinates(
        Eigen::Map<const Eigen::VectorXd>(&tracks.positions[k * width], static_cast<Eigen::Index>(width)));
    track.p.insert(track.p.end(), p.data(), p.data() + p.size());
  }
  track.rotation.assign(track.frames, Eigen::Matrix3d::Identity());
  track.translation.assign(track.frames, Vec3::Zero());
  return track;
}

// Arrays p (frames x modes), and optionally rotation (frames x 3 x 3) and translation (frames x 3).
Result<Track> from_npz(const std::string& path, Index modes) {
  const auto p = FOLDPROOF_TRY(read_npz_numbers(path, "p"));
  if (p.shape.size() != 2 || p.shape[1] != modes)
    return fail(path, "'p' has not one column per mode", fmt::format("give frames x {}", modes));
  Track track{static_cast<Index>(p.shape[0]), modes, p.values, {}, {}};
  track.rotation.assign(track.frames, Eigen::Matrix3d::Identity());
  track.translation.assign(track.frames, Vec3::Zero());
  for (const auto& [name, numbers] : {std::pair("rotation", 9u), std::pair("translation", 3u)}) {
    const auto there = FOLDPROOF_TRY(npz_has_array(path, name));
    if (!there) continue;
    const auto array = FOLDPROOF_TRY(read_npz_numbers(path, name));
    if (array.values.size() != std::size_t{track.frames} * numbers)
      return fail(path, fmt::format("'{}' has not {} numbers per frame", name, numbers),
                  "give them for all frames");
    for (Index k = 0; k < track.frames; ++k) {
      const double* from = &array.values[std::size_t{k} * numbers];
      if (numbers == 9) {
        track.rotation[k] = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(from);
      } else {
        track.translation[k] = Eigen::Map<const Vec3>(from);
      }
    }
  }
  return track;
}

Result<Track> read_track(const std::string& path, const Learned& learned) {
  const Index modes = learned.pca.modes();
  if (std::filesystem::path(path).extension() == ".npz") {
    const auto tracked = FOLDPROOF_TRY(npz_has_array(path, "keypoints"));
    return tracked ? from_tracks(path, learned) : from_npz(path, modes);
  }
  const auto table = FOLDPROOF_TRY(read_csv(path));
  // A row of as many numbers as coordinates have is one of coordinates, unless names say otherwise.
  const std::uint64_t columns = table.shape[1];
  const bool named = !table.names.empty() && table.names[0] == "frame";
  const bool coordinates = columns == modes || columns == modes + 7;
  const bool tracked = named || (!coordinates && columns == 3 * learned.key_points.vertices.size());
  return tracked ? from_tracks(path, learned) : from_csv(path, modes);
}

// Balls around the mean, and around the clusters if there are several.
Result<std::shared_ptr<const ReducedShape>> shape_of(const Model& model, double thickness,
                                                     const ReducedHooks& hooks) {
  auto motion = FOLDPROOF_TRY(ReducedMotion::make(model.hierarchy(), model.learned->pca));
  std::vector<ReducedCenter> centers{{std::vector<double>(motion.modes(), 0.0)}};
  const Clusters& clusters = model.learned->clusters;
  for (Index c = 0; clusters.count() > 1 && c < clusters.count(); ++c) {
    const auto center = clusters.centers.col(c);
    centers.push_back({{center.data(), center.data() + center.size()}});
  }
  // Enough for the thickness and the tolerance.
  ReducedSettings settings;
  if (thickness > 0) settings.clearance = thickness * 1.001 + model.learned->size * 0x1p-24;
  auto shape = FOLDPROOF_TRY(ReducedShape::build(std::make_shared<const ReducedMotion>(std::move(motion)),
                                                 std::move(centers), settings, hooks));
  return std::make_shared<const ReducedShape>(std::move(shape));
}

struct Objects {
  std::vector<ReducedChecker::Object> shapes;
  std::vector<Track> tracks;
};

Result<Objects> open_objects(const ReducedCheckArguments& a, const ReducedHooks& hooks) {
  if (a.files.size() % 2 != 0)
    return fail("--reduced", "takes a model and coordinates for each object",
                "give MODEL COORDINATES in turn");
  Objects objects;
  for (std::size_t i = 0; i < a.files.size(); i += 2) {
    const auto model = FOLDPROOF_TRY(load_learned_model(a.files[i]));
    auto track = FOLDPROOF_TRY(read_track(a.files[i + 1], *model.learned));
    if (track.frames == 0) return fail(a.files[i + 1], "has no frames", "give at least one");
    if (track.frames < 2 && a.steps_only)
      return fail(a.files[i + 1], "has 1 frame, and a step goes from one frame to the next",
                  "check it without --steps-only: its crossing triangles are found");
    if (!objects.tracks.empty() && objects.tracks[0].frames != track.frames) {
      return fail(a.files[i + 1],
                  fmt::format("has {} frames, not {}", track.frames, objects.tracks[0].frames),
                  "give all objects equally many");
    }
    auto shape = FOLDPROOF_TRY(shape_of(model, a.step.thickness, hooks));
    objects.shapes.emplace_back(std::move(shape), model.charts);
    objects.tracks.push_back(std::move(track));
  }
  return objects;
}

std::string start_of(const CheckTotals& totals) {
  if (!totals.starts_crossing) return "not tested for crossings in frame 0 (--steps-only)\n";
  if (*totals.starts_crossing == 0) return "no triangles cross in frame 0\n";
  return fmt::format("frame 0 starts with {} of triangles\n",
                     counted(*totals.starts_crossing, "crossing pair"));
}

std::string summary_of(const CheckTotals& totals) {
  std::string text = start_of(totals);
  text +=
      fmt::format("{}, {} with collisions\n", counted(totals.steps, "step"), totals.steps_with_collisions);
  text += fmt::format("{} of vertex and face, {} of two edges\n", grouped(totals.collisions.vertex_face),
                      grouped(totals.collisions.edge_edge));
  if (totals.listed.sum() < totals.collisions.sum()) {
    text += fmt::format("listed {} of {}\n", grouped(totals.listed.sum()), grouped(totals.collisions.sum()));
  }
  if (totals.worst) {
    text += fmt::format("worst step {}: {}\n", totals.worst->frame,
                        counted(totals.worst_collisions.sum(), "collision"));
    text += fmt::format("first contact at {:.3f} of step {}\n", totals.earliest_toi, totals.earliest->frame);
  }
  return text + fmt::format("{} looked at, {} tested, {:.3g} ms in all\n",
                            counted(totals.work.certificate_tests + totals.work.node_tests, "pair of nodes"),
                            counted(totals.work.leaf_pairs, "pair of leaves"), totals.milliseconds.total);
}

/// Which triangles cross in the first frame: that is a question about vertices, not about coordinates.
Result<void> ask_start(const Objects& objects, const ReducedCheckArguments& a, ReportWriter* csv,
                       CheckTotals& totals) {
  std::vector<Object> meshes;
  std::vector<std::vector<double>> vertices;
  for (std::size_t i = 0; i < objects.shapes.size(); ++i) {
    const ReducedMotion& motion = *objects.shapes[i].shape->motion();
    meshes.emplace_back(objects.shapes[i].charts);
    vertices.emplace_back(3 * std::size_t{motion.hierarchy()->topology().vertex_count()});
    pose_vertices(motion, objects.tracks[i].pose(0), vertices.back());
  }
  const std::vector<std::span<const double>> x(vertices.begin(), vertices.end());
  StaticResult found;
  StepChecker checker(std::move(meshes));
  if (auto done = checker.check_static(x, a.step, found); !done) {
    done.error().where = "frame 0, " + done.error().where;
    return done;
  }
  const CheckedStep pose{.index = {},
                         .collisions = {.triangle_triangle = found.crossing_count},
                         .work = found.work,
                         .milliseconds = found.milliseconds,
                         .x0 = x,
                         .x1 = x,
                         .pose = &found};
  totals.start(pose);
  return csv != nullptr ? csv->start(pose) : Result<void>{};
}

/// False: interrupted, and no file is finished.
Result<bool> run(const Objects& objects, const ReducedCheckArguments& a, ReportWriter* csv,
                 CheckTotals& totals) {
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  const Index frames = objects.tracks[0].frames;
  const Index steps = std::max<Index>(frames, 2) - 1;  // A single frame stands still.
  totals.last_frame = frames - 1;
  totals.steps_expected = steps;
  if (!a.steps_only) {
    FOLDPROOF_TRY(ask_start(objects, a, csv, totals));
  }
  ReducedChecker checker(objects.shapes);
  StepResult found;
  std::vector<ReducedPose> start, end;
  for (Index k = 0; k < steps; ++k) {
    if (interrupted) return false;
    const Index next = std::min(k + 1, frames - 1);
    start.clear();
    end.clear();
    for (const Track& track : objects.tracks) {
      start.push_back(track.pose(k));
      end.push_back(track.pose(next));
    }
    if (auto done = checker.check(start, end, a.step, found); !done) {
      done.error().where = fmt::format("step {}, {}", k, done.error().where);
      return tl::unexpected(done.error());
    }
    const CheckedStep step{.index = {k, k, next, 0},
                           .collisions = {found.vertex_face_count, found.edge_edge_count, 0},
                           .earliest_toi = found.earliest_toi,
                           .work = found.work,
                           .milliseconds = found.milliseconds,
                           .x0 = {},
                           .x1 = {},
                           .step = &found};
    totals.add(step);
    if (csv == nullptr) continue;
    FOLDPROOF_TRY(csv->step(step));
  }
  if (csv == nullptr) return true;
  FOLDPROOF_TRY(csv->finish(totals));
  return true;
}

int tell_interrupted(const CheckTotals& totals) {
  print_error({"interrupted", fmt::format("stopped at {} of {} steps", totals.steps, totals.steps_expected),
               "no report was written"});
  return kExitInterrupted;
}

}  // namespace

Result<int> check_reduced(const ReducedCheckArguments& a) {
  ProgressBar bar(!a.quiet);
  ReducedHooks hooks;
  hooks.progress = [&](double part) { bar.show(part, "proving balls"); };
  hooks.cancel = &watch_for_interrupt();
  const auto objects = open_objects(a, hooks);
  bar.clear();
  if (!objects && *hooks.cancel) return tell_interrupted({});
  if (!objects) return tl::unexpected(objects.error());
  std::unique_ptr<ReportWriter> csv;
  if (!a.csv.empty()) {
    auto writer = FOLDPROOF_TRY(csv_report(a.csv));
    csv = std::move(writer);
  }
  CheckTotals totals;
  const auto finished = FOLDPROOF_TRY(run(*objects, a, csv.get(), totals));
  if (!finished) return tell_interrupted(totals);
  if (!a.quiet) print_output(summary_of(totals));
  return exit_code(totals.clean());
}

}  // namespace foldproof
