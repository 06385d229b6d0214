// The paper's pictures.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <numeric>

#include "generated.h"
#include "report/report.h"
#include "reproduce.h"

namespace foldproof::reproduce {
namespace {

using Frame = std::vector<double>;

Result<Frame> read(Motion& motion, Index frame) {
  Frame x(std::size_t{motion.topology().vertex_count()} * 3);
  if (const auto done = motion.read_frame(frame, x); !done) return tl::unexpected(done.error());
  return x;
}

Eigen::Map<const Eigen::VectorXd> vector_of(const Frame& x) {
  return {x.data(), static_cast<Eigen::Index>(x.size())};
}
Frame frame_of(const Eigen::VectorXd& x) { return {x.begin(), x.end()}; }
Vec3 vertex(std::span<const double> x, Index v) { return Eigen::Map<const Vec3>(&x[3 * std::size_t{v}]); }

std::vector<Vec3> vertices(const Frame& x, std::span<const Index> ids) {
  std::vector<Vec3> places;
  for (const Index v : ids) places.push_back(vertex(x, v));
  return places;
}

double size_of(const Frame& x) {
  Eigen::AlignedBox3d box;
  for (std::size_t k = 0; k < x.size(); k += 3) box.extend(Eigen::Map<const Vec3>(&x[k]));
  return box.sizes().maxCoeff();
}

/// Distances of vertices, mesh units.
std::vector<double> errors_of(const Frame& a, const Frame& b) {
  std::vector<double> errors;
  for (Index v = 0; v < a.size() / 3; ++v) errors.push_back((vertex(a, v) - vertex(b, v)).norm());
  return errors;
}
std::vector<Colour> error_colours(std::span<const double> errors, double darkest) {
  std::vector<Colour> colours;
  for (const double error : errors)
    colours.push_back(map_colour(ColourMap::Error, darkest > 0 ? error / darkest : 0));
  return colours;
}
double largest(std::span<const double> values) { return *std::max_element(values.begin(), values.end()); }

std::vector<Colour> marked_colours(std::span<const std::uint8_t> marks) {
  std::vector<Colour> colours;
  for (const std::uint8_t mark : marks) colours.push_back(mark ? colours::kRed : colours::kClay);
  return colours;
}

/// "0.012 (0.4 %)": a distance in mesh units, and as a share of the size.
std::string distance_text(double distance, double size) {
  return fmt::format("{:.3g} ({:.2g} %)", distance, 100 * distance / size);
}

/// The mean over the vertices, and the worst, for all frames of a motion.
struct Errors {
  double mean = 0, worst = 0;
};
struct MotionErrors {
  Errors all_points, key_points;
};
Result<MotionErrors> errors_over(Motion& motion, const Predictor& predictor) {
  MotionErrors errors;
  for (Index k = 0; k < motion.frame_count(); ++k) {
    const auto x = read(motion, k);
    if (!x) return tl::unexpected(x.error());
    const PoseError error = predictor.error(vector_of(*x));
    for (const auto& [of, out] :
         {std::pair(&error.projection, &errors.all_points), {&error.total, &errors.key_points}}) {
      out->mean += of->mean / motion.frame_count();
      out->worst = std::max(out->worst, of->worst);
    }
  }
  return errors;
}

constexpr std::array<std::array<double, 3>, 14> kDirections{{{1, 0, 0},
                                                             {-1, 0, 0},
                                                             {0, 1, 0.01},
                                                             {0, -1, 0.01},
                                                             {0, 0, 1},
                                                             {0, 0, -1},
                                                             {1, 1, 1},
                                                             {1, 1, -1},
                                                             {1, -1, 1},
                                                             {1, -1, -1},
                                                             {-1, 1, 1},
                                                             {-1, 1, -1},
                                                             {-1, -1, 1},
                                                             {-1, -1, -1}}};

/// Contacts hide in folds: the direction from which most of the red is seen.
Result<View> best_view(const PictureMesh& mesh, const Vec3& up, const View::Focus& focus) {
  View best{.focus = focus};
  std::ptrdiff_t most = -1;
  for (const auto& direction : kDirections) {
    const Panel panel{.meshes = {mesh}, .view = {.from = Vec3(direction.data()), .up = up, .focus = focus}};
    const auto image = draw_picture(std::span(&panel, 1), {.width = 120, .height = 120, .samples = 1});
    if (!image) return tl::unexpected(image.error());
    const auto red = std::count_if(image->pixels.begin(), image->pixels.end(),
                                   [](const Colour& c) { return c.red > 2 * c.green; });
    if (red <= most) continue;
    most = red;
    best = panel.view;
  }
  return best;
}

/// Rounds worth a picture: the first set, what the next two add, and the last.
std::vector<std::size_t> shown_rounds(std::size_t count) {
  std::vector<std::size_t> rounds;
  for (const std::size_t round : {std::size_t{0}, std::size_t{1}, count - 1}) {
    if (round < count && (rounds.empty() || rounds.back() < round)) rounds.push_back(round);
  }
  return rounds;
}

std::string round_table(const KeyPoints& keys, double size) {
  std::string text = "| round | key points | left over (rms) |\n|---|---|---|\n";
  std::size_t next = 0;
  for (std::size_t round = 0; round < keys.round_ends.size(); ++round) {
    if (round != next && round + 1 != keys.round_ends.size()) continue;
    next = std::max<std::size_t>(1, 2 * round);
    text += fmt::format("| {} | {} | {} |\n", round == 0 ? "first set" : std::to_string(round),
                        keys.round_ends[round], distance_text(keys.errors[round], size));
  }
  return text;
}

}  // namespace

Result<void> Figures::write(const std::string& file, std::span<const Panel> panels,
                            const PictureSettings& settings) const {
  const auto image = draw_picture(panels, settings);
  if (!image) return tl::unexpected(image.error());
  return write_png((std::filesystem::path(directory_) / file).string(), *image);
}

Result<Figure> Figures::key_points(Subject& subject, const Model& model) const {
  const auto x = read(*subject.poses, 0);
  if (!x) return tl::unexpected(x.error());
  const KeyPoints& keys = model.learned->key_points;
  const std::span<const Index> ids = keys.vertices;
  std::vector<Panel> panels;
  std::string shown;
  for (const std::size_t round : shown_rounds(keys.round_ends.size())) {
    const Index end = keys.round_ends[round], begin = round == 0 ? 0 : keys.round_ends[round - 1];
    Panel panel{.meshes = {{&subject.poses->topology(), *x}}, .view = subject.view};
    panel.points.push_back({vertices(*x, ids.first(begin)), colours::kRed});
    panel.points.push_back(
        {vertices(*x, ids.subspan(begin, end - begin)), round == 0 ? colours::kRed : colours::kBlue});
    panels.push_back(std::move(panel));
    shown += round == 0   ? "the first set, evenly spread by radius thinning"
             : round == 1 ? ", then after the first round"
                          : ", and after the last";
  }
  const std::string file = subject.id + "-key-points.png";
  if (auto done = write(file, panels, {.width = 960, .height = 300, .columns = 3}); !done)
    return tl::unexpected(done.error());
  const std::string added =
      panels.size() == 1
          ? ""
          : " Red is what earlier rounds chose, blue what this one adds: of each basis vector the "
            "vertex that moves most, and the one that moves most against it.";
  return Figure{
      {file},
      fmt::format("{}: {}.{}\n\n{}", subject.name, shown, added, round_table(keys, model.learned->size))};
}

Result<Figure> Figures::training_poses(Subject& subject) const {
  const auto poses = read_frames(*subject.poses);
  if (!poses) return tl::unexpected(poses.error());
  std::vector<Panel> panels;
  const std::size_t count = std::min<std::size_t>(poses->size(), 10);
  for (std::size_t k = 0; k < count; ++k) {
    const Frame& x = (*poses)[k * poses->size() / count];
    panels.push_back({.meshes = {{&subject.poses->topology(), x}}, .view = subject.view});
  }
  const std::string file = subject.id + "-poses.png";
  if (auto done = write(file, panels, {.width = 960, .height = 360, .columns = 5}); !done)
    return tl::unexpected(done.error());
  return Figure{{file}, fmt::format("{} of the {} poses that are learned from.", count, poses->size())};
}

Result<Figure> Figures::prediction(Subject& subject, const Model& model) const {
  const auto x = read(*subject.motion, subject.bent);
  if (!x) return tl::unexpected(x.error());
  const Predictor predictor(model.learned);
  const auto& ids = model.learned->key_points.vertices;
  const Frame predicted =
      frame_of(predictor.from_key_points(predictor.key_point_map().gather(vector_of(*x))));
  const auto errors = errors_of(predicted, *x);
  const auto colours = error_colours(errors, largest(errors));
  const Topology& topology = subject.motion->topology();
  const PicturePoints points{vertices(*x, ids), colours::kRed};
  const std::vector<Panel> panels{
      {.points = {points}, .view = subject.view},
      {.meshes = {{&topology, predicted}}, .points = {points}, .view = subject.view},
      {.meshes = {{.topology = &topology, .positions = predicted, .vertex_colours = colours}},
       .view = subject.view}};
  const std::string file = subject.id + "-prediction.png";
  if (auto done = write(file, panels, {.width = 960, .height = 300, .columns = 3}); !done)
    return tl::unexpected(done.error());
  const double mean = std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
  const double size = model.learned->size;
  return Figure{
      {file},
      fmt::format(
          "A pose that was not learned from. Left all that is known of it, {} of {} vertices; middle the "
          "mesh that they predict; right the same with its distance from the true pose: pale grey is none, "
          "dark "
          "purple the largest. Mean {}, largest {}.",
          ids.size(), topology.vertex_count(), distance_text(mean, size),
          distance_text(largest(errors), size))};
}

Result<Figure> Figures::bent(Subject& subject, const Model& model) const {
  if (subject.limb.empty()) return Figure{};
  const auto rest = read(*subject.poses, 0), bent = read(*subject.motion, subject.bent);
  if (!rest) return tl::unexpected(rest.error());
  if (!bent) return tl::unexpected(bent.error());
  StepChecker checker({model.hierarchy()});
  StaticResult answer;
  if (auto done = checker.check_static(*bent, {}, answer); !done) return tl::unexpected(done.error());
  const Topology& topology = subject.motion->topology();
  const auto colours = marked_colours(colliding_faces(topology, 0, answer));
  const std::vector<Panel> panels{
      {.meshes = {{&topology, *rest}}, .view = subject.view},
      {.meshes = {{.topology = &topology, .positions = *bent, .face_colours = colours}},
       .view = subject.view}};
  const std::string file = subject.id + "-bent.png";
  if (auto done = write(file, panels, {.width = 800, .height = 400, .columns = 2}); !done)
    return tl::unexpected(done.error());
  return Figure{
      {file},
      fmt::format("{}: left as it is, right with {} bent inwards (frame {} of the motion). Red: faces "
                  "that cross, {} pairs.",
                  subject.name, subject.limb, subject.bent, answer.crossing_count)};
}

Result<Figure> Figures::collision(Subject& subject, const WorstStep& worst) const {
  const StepResult& answer = worst.answer;
  const std::uint64_t pairs = answer.count();
  if (pairs == 0) return Figure{{}, subject.name + " nowhere meets itself in its motion."};
  auto x = read(*subject.motion, worst.frame);
  const auto next = read(*subject.motion, worst.frame + 1);
  if (!x) return tl::unexpected(x.error());
  if (!next) return tl::unexpected(next.error());
  for (std::size_t k = 0; k < x->size(); ++k) (*x)[k] = std::lerp((*x)[k], (*next)[k], answer.earliest_toi);

  const Topology& topology = subject.motion->topology();
  const auto marks = colliding_faces(topology, 0, answer);
  const auto colours = marked_colours(marks);
  const PictureMesh mesh{.topology = &topology, .positions = *x, .face_colours = colours};
  Eigen::AlignedBox3d box;
  for (std::size_t face = 0; face < marks.size(); ++face) {
    for (const Index v : topology.triangles()[face]) {
      if (marks[face]) box.extend(vertex(*x, v));
    }
  }
  const double radius = std::clamp(0.75 * box.sizes().maxCoeff(), 0.06 * size_of(*x), 0.3 * size_of(*x));
  const auto near = best_view(mesh, subject.view.up, {box.center(), radius});
  if (!near) return tl::unexpected(near.error());
  const std::vector<Panel> panels{{.meshes = {mesh}, .view = subject.view},
                                  {.meshes = {mesh}, .view = *near}};
  const std::string file = subject.id + "-collision.png";
  if (auto done = write(file, panels, {.width = 800, .height = 400, .columns = 2, .same_scale = false});
      !done)
    return tl::unexpected(done.error());
  return Figure{
      {file},
      fmt::format("{} collides with itself between frames {} and {} of its motion: {} pairs, the first "
                  "{:.3f} of the way, the pose that is shown. Red: faces that take part; right from near.",
                  subject.name, worst.frame, worst.frame + 1, pairs, answer.earliest_toi)};
}

Result<Figure> Figures::rebuilt(Subject& subject, const Model& model) const {
  const auto x = read(*subject.motion, subject.bent);
  if (!x) return tl::unexpected(x.error());
  const Predictor predictor(model.learned);
  const auto& ids = model.learned->key_points.vertices;
  const Frame all = frame_of(predictor.from_all_points(vector_of(*x)));
  const Frame keys = frame_of(predictor.from_key_points(predictor.key_point_map().gather(vector_of(*x))));
  const auto all_errors = errors_of(all, *x), key_errors = errors_of(keys, *x);
  const double darkest = std::max(largest(all_errors), largest(key_errors));
  const auto all_colours = error_colours(all_errors, darkest),
             key_colours = error_colours(key_errors, darkest);
  const Topology& topology = subject.motion->topology();
  const std::vector<Panel> panels{
      {.meshes = {{&topology, *x}}, .view = subject.view},
      {.meshes = {{&topology, all}}, .view = subject.view},
      {.meshes = {{&topology, keys}}, .view = subject.view},
      {.meshes = {{&topology, *x}},
       .points = {{vertices(*x, ids), colours::kRed, 0.008}},
       .view = subject.view},
      {.meshes = {{.topology = &topology, .positions = all, .vertex_colours = all_colours}},
       .view = subject.view},
      {.meshes = {{.topology = &topology, .positions = keys, .vertex_colours = key_colours}},
       .view = subject.view}};
  const std::string file = subject.id + "-rebuilt.png";
  if (auto done = write(file, panels, {.width = 840, .height = 520, .columns = 3}); !done)
    return tl::unexpected(done.error());
  const auto errors = errors_over(*subject.motion, predictor);
  if (!errors) return tl::unexpected(errors.error());
  const double size = model.learned->size;
  return Figure{
      {file},
      fmt::format(
          "{}, frame {} of its motion. Left the original, below with its {} key points ({:.1f} % of the "
          "vertices); middle rebuilt from all points, the best that the subspace of {} modes can do; "
          "right from key points alone. Below, distance from the original: pale grey is none, dark "
          "purple {}.\n\n| over all frames | mean | worst |\n|---|---|---|\n| from all points | {} | {} |\n"
          "| from key points | {} | {} |\n",
          subject.name, subject.bent, ids.size(), 100.0 * ids.size() / topology.vertex_count(),
          model.learned->pca.modes(), distance_text(darkest, size),
          distance_text(errors->all_points.mean, size), distance_text(errors->all_points.worst, size),
          distance_text(errors->key_points.mean, size), distance_text(errors->key_points.worst, size))};
}

Result<Figure> Figures::missing_direction(Size size, const Hooks& hooks) const {
  using std::numbers::pi;
  const Cylinder mesh = size == Size::Full ? Cylinder(64, 100) : Cylinder(24, 32);
  const Frame truth = mesh.pose(0.7 * pi, pi / 2);
  std::vector<Frame> poses{mesh.pose(0, 0)};
  for (const double bend : {0.3, 0.6, 0.9}) {
    poses.push_back(mesh.pose(bend * pi, 0));
    poses.push_back(mesh.pose(bend * pi, pi));
  }
  std::vector<Frame> predicted;
  std::string rows;
  for (const char* name : {"one plane only", "and one example across"}) {
    const auto motion = memory_motion("cylinder", mesh.topology(), poses);
    std::vector<TrainPose> all;
    for (Index k = 0; k < motion->frame_count(); ++k) all.push_back({motion.get(), k});
    TrainHooks training;
    training.cancel = hooks.cancel;
    const auto model = train_model(all, {.references = 1}, training);
    if (!model) return tl::unexpected(model.error());
    if (!model->learned)
      return fail("the cylinder", "teaches nothing: " + model->not_learned, "please report this");
    const Predictor predictor(model->learned);
    predicted.push_back(
        frame_of(predictor.from_key_points(predictor.key_point_map().gather(vector_of(truth)))));
    const auto errors = errors_of(predicted.back(), truth);
    const double mean =
        std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
    rows +=
        fmt::format("| {} | {} | {} | {} |\n", name, poses.size(), distance_text(mean, model->learned->size),
                    distance_text(largest(errors), model->learned->size));
    poses.push_back(mesh.pose(0.85 * pi, pi / 2));
  }
  const View view{.from = {0.3, -0.5, 1}};
  std::vector<Panel> panels{{.meshes = {{&mesh.topology(), truth}}, .view = view}};
  for (const Frame& x : predicted) panels.push_back({.meshes = {{&mesh.topology(), x}}, .view = view});
  const std::string file = "cylinder-missing-direction.png";
  if (auto done = write(file, panels, {.width = 960, .height = 280, .columns = 3}); !done)
    return tl::unexpected(done.error());
  return Figure{
      {file},
      "The paper warns of directions without an example. Left the true pose; middle what key points make of "
      "it "
      "when the cylinder was only ever seen to bend in the plane across; right with one further example "
      "in that direction.\n\n| learned from | poses | mean | worst |\n|---|---|---|---|\n" +
          rows};
}

}  // namespace foldproof::reproduce
