#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "commands.h"
#include "options.h"
#include "picture/picture.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kFooter = R"(  pose.obj                        a single pose
Several motions are several objects in one picture. The camera is fitted to what it sees; y points up.

Colours of --color:
  plain         none
  collisions    red: faces that collide between this frame and the next, in the pose of the first contact; pink:
                faces that cross in this frame already. For the last frame, or a single pose, pink alone
  certificates  blue: proven free of contact between this frame and the next, the paler the smaller the patch that
                the proof is for; other colours: why not (docs/reports.md, --explain)
  error         distance of each vertex from --truth: pale grey is none, then yellow, red, and dark purple for the
                largest, or for --scale

Examples:
  foldproof render walk.glb -o walk.png                             frame 0 from the front
  foldproof render walk.glb --frame 12 --color collisions -o c.png  what collides on the way to frame 13
  foldproof render body.npz --color certificates --model body.model -o p.png
  foldproof render rebuilt.npz --color error --truth walk.glb --frame 3 -o e.png
  foldproof render walk.glb --view 1,0.5,1 --size 600x900 -o w.png  from the upper front right)";

struct RenderArguments {
  std::vector<std::string> motions, models;
  std::string picture, truth, color = "plain", view = "front", size = "1200x900";
  std::int64_t frame = 0;
  double scale = 0;
  bool flat = false, quiet = false;
  ReadOptions read;
  FileArguments files;
};

using Objects = std::vector<std::unique_ptr<Motion>>;
/// Numbers of all objects at one time, as queries take them.
struct Poses {
  std::vector<std::vector<double>> objects;
  std::vector<std::span<const double>> spans() const { return {objects.begin(), objects.end()}; }
};
/// What is to be seen, and a line about it.
struct Coloured {
  Poses poses;
  std::vector<std::vector<Colour>> faces, vertices;  ///< Per object; or none.
  std::string told;
};

Result<Poses> read(const Objects& motions, Index frame) {
  Poses poses;
  for (const auto& motion : motions) {
    poses.objects.emplace_back(std::size_t{motion->topology().vertex_count()} * 3);
    if (const auto done = motion->read_frame(frame, poses.objects.back()); !done)
      return tl::unexpected(done.error());
  }
  return poses;
}

/// Negative frames count from the end.
Result<Index> frame_of(const RenderArguments& a, const Objects& motions) {
  const std::int64_t count = motions[0]->frame_count();
  for (const auto& motion : motions) {
    if (motion->frame_count() != count)
      return fail(
          motion->name(),
          fmt::format("has {} frames, but {} has {}", motion->frame_count(), motions[0]->name(), count),
          "objects in one picture need equally many frames");
  }
  const std::int64_t frame = a.frame < 0 ? a.frame + count : a.frame;
  if (frame >= 0 && frame < count) return static_cast<Index>(frame);
  return fail("--frame", fmt::format("there is no frame {} among {}", a.frame, count),
              "frames count from 0, negative ones from the end");
}

Result<std::array<Index, 2>> size_of(const std::string& text) {
  std::array<Index, 2> size{};
  const char* end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size[0]);
  if (width.ec == std::errc{} && width.ptr != end && *width.ptr == 'x') {
    const auto height = std::from_chars(width.ptr + 1, end, size[1]);
    if (height.ec == std::errc{} && height.ptr == end && size[0] > 0 && size[1] > 0) return size;
  }
  return fail("--size", fmt::format("'{}' is no size", text), "give pixels as WIDTHxHEIGHT, as in 1200x900");
}

/// A checker of all objects, with the models that fit them.
Result<StepChecker> checker_of(const RenderArguments& a, const Objects& motions, const Poses& poses) {
  std::vector<std::shared_ptr<const Model>> models(motions.size());
  for (const std::string& path : a.models) {
    auto loaded = load_model(path);
    if (!loaded) return tl::unexpected(loaded.error());
    const auto model = std::make_shared<const Model>(std::move(*loaded));
    bool used = false;
    for (std::size_t i = 0; i < motions.size(); ++i) {
      if (models[i] || !(model->hierarchy()->topology() == motions[i]->topology())) continue;
      models[i] = model;
      used = true;
    }
    if (!used) return fail(path, "is a model of none of these meshes", "train a model on one of them");
  }
  std::vector<Object> objects;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (models[i]) {
      objects.push_back(models[i]->object());
      continue;
    }
    auto built = Hierarchy::build(motions[i]->topology(), poses.objects[i]);
    if (!built) return tl::unexpected(built.error());
    objects.emplace_back(std::move(*built));
  }
  return StepChecker(std::move(objects));
}

/// Faces that an answer names in `colour`, over those that have one already.
template <class Answer>
void mark(const Objects& motions, const Answer& answer, Colour colour, Coloured& out) {
  out.faces.resize(motions.size());
  for (Index object = 0; object < motions.size(); ++object) {
    const auto marks = colliding_faces(motions[object]->topology(), object, answer);
    out.faces[object].resize(marks.size(), colours::kClay);
    for (std::size_t face = 0; face < marks.size(); ++face)
      if (marks[face]) out.faces[object][face] = colour;
  }
}

Result<void> colour_crossings(StepChecker& checker, const Objects& motions, Index frame, Coloured& out) {
  StaticResult answer;
  if (auto done = checker.check_static(out.poses.spans(), {}, answer); !done) return done;
  mark(motions, answer, colours::kPink, out);
  out.told =
      fmt::format("{} of triangles in frame {}", counted(answer.crossing_count, "crossing pair"), frame);
  return {};
}

Result<void> colour_collisions(const RenderArguments& a, const Objects& motions, Index frame, Coloured& out) {
  auto checker = checker_of(a, motions, out.poses);
  if (!checker) return tl::unexpected(checker.error());
  if (auto done = colour_crossings(*checker, motions, frame, out); !done) return done;
  if (frame + 1 == motions[0]->frame_count()) return {};
  const auto next = read(motions, frame + 1);
  if (!next) return tl::unexpected(next.error());
  StepResult answer;
  if (auto done = checker->check(out.poses.spans(), next->spans(), {}, answer); !done) return done;
  mark(motions, answer, colours::kRed, out);
  const std::uint64_t pairs = answer.count();
  out.told += fmt::format("; {} on the way to the next", counted(pairs, "colliding pair"));
  if (pairs == 0) return {};
  out.told += fmt::format(", the first {:.4f} of the way", answer.earliest_toi);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    std::vector<double>& x = out.poses.objects[i];
    for (std::size_t k = 0; k < x.size(); ++k)
      x[k] = std::lerp(x[k], next->objects[i][k], answer.earliest_toi);
  }
  return {};
}

/// A checker draws charts from step to step, so the same step is answered until nothing is left to be drawn.
Result<void> colour_certificates(const RenderArguments& a, const Objects& motions, Index frame,
                                 Coloured& out) {
  if (frame + 1 == motions[0]->frame_count())
    return fail("--color", "certificates are of the step to the next frame, and this is the last one",
                "give another --frame");
  const auto next = read(motions, frame + 1);
  if (!next) return tl::unexpected(next.error());
  auto checker = checker_of(a, motions, out.poses);
  if (!checker) return tl::unexpected(checker.error());
  constexpr int kMostSteps = 32;
  constexpr auto kNotDrawn = static_cast<std::size_t>(Reason::NotDrawn);
  StepResult answer;
  for (int step = 0; step < kMostSteps && !watch_for_interrupt(); ++step) {
    if (auto done = checker->check(out.poses.spans(), next->spans(), {.explain = true}, answer); !done)
      return done;
    if (answer.explanation.leaf_pairs[kNotDrawn] == 0) break;
  }
  std::uint64_t proven = 0, faces = 0;
  for (const Explanation::Object& object : answer.explanation.objects) {
    std::vector<Colour> colours;
    for (std::size_t t = 0; t < object.level.size(); ++t) {
      const auto rgb = explanation_colour(object.reason[t], object.level[t]);
      colours.push_back({rgb[0], rgb[1], rgb[2]});
      proven += object.reason[t] == Reason::Certified;
    }
    faces += colours.size();
    out.faces.push_back(std::move(colours));
  }
  out.told = fmt::format("{} of {} faces proven free of contact", grouped(proven), grouped(faces));
  return {};
}

Result<void> colour_error(const RenderArguments& a, const Objects& motions, Coloured& out) {
  const std::string truth_name[] = {a.truth};
  const auto truth = open_motions(truth_name, a.read);
  if (!truth) return tl::unexpected(truth.error());
  const auto frame = (*truth)[0]->frame_count() == 1 ? Result<Index>(0) : frame_of(a, *truth);
  if (!frame) return tl::unexpected(frame.error());
  const auto meant = read(*truth, *frame);
  if (!meant) return tl::unexpected(meant.error());
  if (motions.size() != 1 || meant->objects[0].size() != out.poses.objects[0].size())
    return fail("--truth", "is another mesh", "give a motion with the same vertices in the same order");

  std::vector<double> errors;
  double sum = 0, worst = 0;
  for (std::size_t k = 0; k < meant->objects[0].size(); k += 3) {
    using Place = Eigen::Map<const Vec3>;
    errors.push_back((Place(&meant->objects[0][k]) - Place(&out.poses.objects[0][k])).norm());
    sum += errors.back();
    worst = std::max(worst, errors.back());
  }
  const double scale = a.scale > 0 ? a.scale : worst;
  std::vector<Colour> colours;
  colours.reserve(errors.size());
  for (const double error : errors)
    colours.push_back(map_colour(ColourMap::Error, scale > 0 ? error / scale : 0));
  out.vertices.push_back(std::move(colours));
  out.told = fmt::format("distance mean {:.6g}, largest {:.6g} mesh units; darkest from {:.6g} on",
                         sum / static_cast<double>(errors.size()), worst, scale);
  return {};
}

Result<void> require_options_that_fit(const RenderArguments& a) {
  if ((a.color == "error") == a.truth.empty()) {
    return fail("--truth",
                a.truth.empty() ? "is missing: errors are distances from it" : "is for --color error only",
                a.truth.empty() ? "name the motion that is right" : "leave it out");
  }
  if (a.scale != 0 && a.color != "error") return fail("--scale", "is for --color error only", "leave it out");
  return require_number("--scale", a.scale, true);
}

Result<Coloured> colour(const RenderArguments& a, const Objects& motions) {
  const auto frame = frame_of(a, motions);
  if (!frame) return tl::unexpected(frame.error());
  auto poses = read(motions, *frame);
  if (!poses) return tl::unexpected(poses.error());
  Coloured out{.poses = std::move(*poses), .faces = {}, .vertices = {}, .told = {}};
  const auto done = a.color == "collisions"     ? colour_collisions(a, motions, *frame, out)
                    : a.color == "certificates" ? colour_certificates(a, motions, *frame, out)
                    : a.color == "error"        ? colour_error(a, motions, out)
                                                : Result<void>{};
  if (!done) return tl::unexpected(done.error());
  return out;
}

int tell_interrupted() {
  print_error({"interrupted", "the picture was not finished", "nothing was written"});
  return kExitInterrupted;
}

Result<int> render(const RenderArguments& a) {
  const auto view = parse_view(a.view);
  if (!view) return tl::unexpected(view.error());
  const auto size = size_of(a.size);
  if (!size) return tl::unexpected(size.error());
  if (const auto ok = require_options_that_fit(a); !ok) return tl::unexpected(ok.error());
  if (const auto ok = require_number("--fps", a.read.fps, false); !ok) return tl::unexpected(ok.error());
  if (const auto ok = a.files.check(); !ok) return tl::unexpected(ok.error());
  const auto motions = open_motions(a.motions, a.read);
  if (!motions) return tl::unexpected(motions.error());
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  const auto coloured = colour(a, *motions);
  if (interrupted) return tell_interrupted();
  if (!coloured) return tl::unexpected(coloured.error());

  Panel panel{.view = *view};
  for (std::size_t i = 0; i < motions->size(); ++i) {
    PictureMesh mesh{.topology = &(*motions)[i]->topology(), .positions = coloured->poses.objects[i]};
    if (!coloured->faces.empty()) mesh.face_colours = coloured->faces[i];
    if (!coloured->vertices.empty()) mesh.vertex_colours = coloured->vertices[i];
    mesh.smooth = !a.flat;
    panel.meshes.push_back(mesh);
  }
  const auto image = draw_picture(std::span(&panel, 1), {.width = (*size)[0], .height = (*size)[1]});
  if (!image) return tl::unexpected(image.error());
  if (interrupted) return tell_interrupted();
  if (const auto done = write_png(a.picture, *image); !done) return tl::unexpected(done.error());
  if (!a.quiet && !coloured->told.empty()) print_output(coloured->told + "\n");
  return kExitClean;
}

}  // namespace

Command add_render(CLI::App& program) {
  CLI::App* command = program.add_subcommand("render", "Draw a frame into a PNG file; no display is needed");
  command->footer(std::string(kMotionHelp) + kFooter);
  const auto a = std::make_shared<RenderArguments>();
  FileArguments& files = a->files;
  files.reads(command->add_option("MOTION", a->motions, "What to draw (see below)"))
      ->type_name("")
      ->required();
  files.writes(command->add_option("-o,--output", a->picture, "The picture to write"))
      ->type_name("FILE")
      ->required();
  command->add_option("--frame", a->frame, "Which one; negative ones count from the end [0]")->type_name("K");
  command->add_option("--color", a->color, "plain, collisions, certificates or error (see below) [plain]")
      ->type_name("WHAT")
      ->check(CLI::IsMember({"plain", "collisions", "certificates", "error"}));
  files.reads(command->add_option("--truth", a->truth, "For --color error: what the mesh should be"))
      ->type_name("MOTION");
  command->add_option("--scale", a->scale, "For --color error: what is darkest, in mesh units [the largest]")
      ->type_name("D");
  files
      .reads(
          command->add_option("--model", a->models, "What 'foldproof train' found out: more can be proven"))
      ->type_name("FILE")
      ->allow_extra_args(false);
  command
      ->add_option("--view", a->view, "front, back, side, top, or the direction to the eye as x,y,z [front]")
      ->type_name("VIEW");
  command->add_option("--size", a->size, "In pixels [1200x900]")->type_name("WxH");
  command->add_flag("--flat", a->flat, "Show each triangle as flat as it is");
  command->add_option("--fps", a->read.fps, "Sampling rate for animated glTF, frames per second [24]")
      ->type_name("RATE");
  command->add_flag("--weld", a->read.weld, "Merge vertices that coincide in the first frame");
  command->add_flag("--quiet", a->quiet, "Print nothing but errors");
  return [a] { return render(*a); };
}

}  // namespace foldproof
