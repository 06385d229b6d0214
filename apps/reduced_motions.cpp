#include "reduced_motions.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "base/stopwatch.h"
#include "base/try.h"
#include "options.h"
#include "progress_bar.h"
#include "report/reduced_track.h"
#include "terminal.h"

namespace foldproof {
namespace {

using Frames = ReducedTrack::Frames;

Result<void> wrong_columns(const std::string& path, std::uint64_t columns, Index modes) {
  return fail(path, fmt::format("has {} columns", columns),
              fmt::format("give {0}, one per mode, or {1} with a placement behind them", modes, modes + 7));
}

/// Columns are taken by their place; a name that means another one would turn the motion into a different
/// one.
Result<void> require_names_fit(const std::string& path, const NumberTable& table, Index modes) {
  // Which column of a placement, w x y z tx ty tz, a name may mean; "": none.
  const std::map<std::string, std::string> columns{{"frame", ""}, {"time", ""}, {"t", ""},   {"vertex", ""},
                                                   {"w", "0"},    {"x", "14"},  {"y", "25"}, {"z", "36"},
                                                   {"qw", "0"},   {"qx", "1"},  {"qy", "2"}, {"qz", "3"},
                                                   {"tx", "4"},   {"ty", "5"},  {"tz", "6"}};
  for (std::size_t c = 0; c < table.names.size(); ++c) {
    std::string name = table.names[c];
    std::ranges::transform(name, name.begin(), [](unsigned char letter) { return std::tolower(letter); });
    const auto meant = columns.find(name);
    if (meant == columns.end()) continue;
    if (c >= modes && meant->second.find(std::to_string(c - modes)) != std::string::npos) continue;
    return fail(
        path, fmt::format("has '{}' as column {}", table.names[c], c + 1),
        fmt::format("give {}, one per mode, then maybe w x y z of a quaternion and x y z of a translation",
                    counted(modes, "number")));
  }
  return {};
}

// p, then optionally a quaternion w x y z and a translation x y z per row.
Result<Frames> from_csv(const std::string& path, Index modes) {
  const auto table = FOLDPROOF_TRY(read_csv(path));
  const std::uint64_t columns = table.shape[1];
  if (columns != modes && columns != modes + 7)
    return tl::unexpected(wrong_columns(path, columns, modes).error());
  FOLDPROOF_TRY(require_names_fit(path, table, modes));
  Frames frames;
  for (std::uint64_t k = 0; k < table.shape[0]; ++k) {
    const double* row = &table.values[k * columns];
    frames.p.insert(frames.p.end(), row, row + modes);
    if (columns == modes) continue;
    const double* q = row + modes;
    Eigen::Quaternion<double> turn(q[0], q[1], q[2], q[3]);
    const double largest = turn.coeffs().cwiseAbs().maxCoeff();
    if (largest == 0) return fail(path, fmt::format("row {} has no quaternion", k), "give w x y z");
    for (double& c : turn.coeffs()) c = std::scalbn(c, -std::ilogb(largest));  // so that the norm is finite
    frames.rotation.push_back(turn.normalized().toRotationMatrix());
    frames.translation.emplace_back(q[4], q[5], q[6]);
  }
  return frames;
}

Result<Frames> from_tracks(const std::string& path, const Learned& learned) {
  const auto tracks = FOLDPROOF_TRY(read_key_point_tracks(path, learned.key_points.vertices));
  const KeyPointMap map(learned.pca, learned.key_points.vertices);
  Frames frames;
  const std::size_t width = std::size_t{tracks.points} * 3;
  for (Index k = 0; k < tracks.frames; ++k) {
    const Eigen::VectorXd p = map.coordinates(
        Eigen::Map<const Eigen::VectorXd>(&tracks.positions[k * width], static_cast<Eigen::Index>(width)));
    frames.p.insert(frames.p.end(), p.begin(), p.end());
  }
  return frames;
}

// Arrays p (frames x modes), and optionally rotation (frames x 3 x 3) and translation (frames x 3).
Result<Frames> from_npz(const std::string& path, Index modes) {
  const auto p = FOLDPROOF_TRY(read_npz_numbers(path, "p"));
  if (p.shape.size() != 2 || p.shape[1] != modes)
    return fail(path, "'p' has not one column per mode", fmt::format("give frames x {}", modes));
  const std::uint64_t count = p.shape[0];
  Frames frames{p.values, {}, {}};
  using Shape = std::vector<std::uint64_t>;
  for (const auto& [name, shape] :
       {std::pair("rotation", Shape{count, 3, 3}), std::pair("translation", Shape{count, 3})}) {
    const auto there = FOLDPROOF_TRY(npz_has_array(path, name));
    if (!there) continue;
    const auto array = FOLDPROOF_TRY(read_npz_numbers(path, name));
    if (array.shape != shape)
      return fail(path, fmt::format("'{}' is of shape {}", name, fmt::join(array.shape, " x ")),
                  fmt::format("give {} for the frames of 'p'", fmt::join(shape, " x ")));
    const std::uint64_t numbers = shape.size() == 3 ? 9 : 3;
    for (std::uint64_t k = 0; k < count; ++k) {
      const double* from = &array.values[k * numbers];
      if (numbers == 9) {
        frames.rotation.emplace_back(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(from));
      } else {
        frames.translation.emplace_back(Vec3::load(from));
      }
    }
  }
  return frames;
}

Result<Frames> read_frames(const std::string& path, const Learned& learned) {
  const Index modes = learned.pca.modes();
  if (extension_of(path) == ".npz") {
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

// Those that the model keeps, if they are enough for the thickness and the tolerance; else proves some.
Result<std::shared_ptr<const ReducedShape>> shape_of(const Model& model, double thickness, ProgressBar& bar) {
  const double size = model.learned->size;
  if (model.balls && model.balls->clearance >= thickness * 1.001 + size * 0x1p-26) return kept_balls(model);
  const std::string text = "proving the balls of " + cell(model.name);
  bar.begin(text);
  ReducedHooks hooks;
  hooks.progress = [&](double part) { bar.show(part, text); };
  hooks.cancel = &watch_for_interrupt();
  const double clearance = thickness > 0 ? thickness * 1.001 + size * 0x1p-24 : 0;
  auto shape = prove_balls(model, clearance, hooks);
  bar.clear();
  if (!shape && *hooks.cancel)
    return fail(ErrorCode::Interrupted, "interrupted", "while proving balls", "no report was written");
  return shape;
}

// How to have them at once the next time.
std::string keep_hint(const Model& model, double clearance, double thickness) {
  return fmt::format(
      "Keep the balls of {0}, and the next check has them at once: foldproof radius {0} {1}--save\n",
      printable(model.name), thickness > 0 ? fmt::format("--clearance {:.6g} ", clearance * (1 + 1e-5)) : "");
}

}  // namespace

Result<std::vector<std::unique_ptr<Motion>>> open_reduced(const std::vector<std::string>& files, bool quiet,
                                                          CheckSettings& settings) {
  if (files.size() % 2 != 0)
    return fail(ErrorCode::InvalidArgument, "--reduced", "takes a model and coordinates for each object",
                "give MODEL COORDINATES in turn");
  constexpr double kLong = 2000;  // milliseconds
  ProgressBar bar(!quiet);
  std::vector<std::unique_ptr<Motion>> motions;
  for (std::size_t i = 0; i < files.size(); i += 2) {
    const std::string& coordinates = files[i + 1];
    const auto model = std::make_shared<const Model>(FOLDPROOF_TRY(load_learned_model(files[i])));
    auto frames = FOLDPROOF_TRY(read_frames(coordinates, *model->learned));
    if (frames.p.empty())
      return fail(ErrorCode::InvalidFile, coordinates, "has no frames", "give at least one");
    Stopwatch watch;
    auto shape = FOLDPROOF_TRY(shape_of(*model, settings.step.thickness, bar));
    const double milliseconds = watch.lap();
    settings.ball_milliseconds += milliseconds;
    if (!quiet && milliseconds > kLong)
      print_notice(keep_hint(*model, shape->clearance(), settings.step.thickness));
    auto track = std::make_unique<ReducedTrack>(
        coordinates, ReducedChecker::Object{std::move(shape), model->charts}, std::move(frames));
    settings.reduced.push_back(track.get());
    settings.models.push_back(model);
    motions.push_back(std::move(track));
  }
  return motions;
}

}  // namespace foldproof
