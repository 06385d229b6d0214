#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/try.h"
#include "commands.h"
#include "options.h"
#include "report/contact_pictures.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kRenderFooter = R"(  pose.obj                        a single pose
Several motions are several objects in one picture. The camera is fitted to the whole motion, so that pictures of its
frames go together. The axis that points up is y for glTF. For other files it is guessed: z if the motion stands on
a ground across z, else y. --up sets it.

Views of --view:
  auto          with --color collisions or contacts, the worst contact with the objects around it: along its normal,
                or from where more of it is visible. Else from the front, slightly from the right and from above
  front, back, side, top, or the direction from the objects to the eye as x,y,z

Colors of --color:
  plain         none
  collisions    red: faces that collide between this frame and the next, in the pose of the first contact; pink:
                faces that cross in this frame already. For the last frame, or a single pose, pink alone
  contacts      what is inside what in this frame, or crosses it: one side of each contact is red, the other blue; the
                curves in which they cross are black

Examples:
  foldproof render walk.glb -o walk.png                             frame 0
  foldproof render walk.glb --frame 12 --color collisions -o c.png  what collides on the way to frame 13
  foldproof render walk.glb --frame 12 --color contacts -o c.png    what crosses in frame 12
  foldproof render walk.glb --view 1,0.5,1 --size 600x900 -o w.png  from the upper front right)";

struct RenderArguments {
  RenderArguments() {
    read.still = true;
    read.mesh_files = MeshFiles::Poses;  // a frame of them is drawn
  }

  std::vector<std::string> motions;
  std::string picture, color = "plain", view = "auto", up = "auto", size = "1200x900";
  std::int64_t frame = 0;
  bool flat = false, quiet = false;
  ReadOptions read;
  FileArguments files;
};

using Objects = std::vector<std::unique_ptr<Motion>>;
/// Positions of all objects at one time.
struct Poses {
  std::vector<std::vector<double>> objects;
  std::vector<std::span<const double>> spans() const { return {objects.begin(), objects.end()}; }
};
/// The poses and colors to draw, and a line of text about them.
struct Colored {
  Poses poses;
  std::vector<std::vector<Color>> faces;  ///< Per object; or empty.
  std::vector<Contact> contacts;          ///< Of what collides and crosses, the worst first.
  std::string summary;
};

Result<Poses> read(const Objects& motions, Index frame) {
  Poses poses;
  for (const auto& motion : motions) {
    poses.objects.emplace_back(std::size_t{motion->topology().vertex_count()} * 3);
    FOLDPROOF_TRY(motion->read_frame(frame, poses.objects.back()));
  }
  return poses;
}

/// Negative frames count from the end.
Result<Index> frame_of(const RenderArguments& a, const Objects& motions) {
  const std::int64_t count = motions[0]->frame_count();
  for (const auto& motion : motions) {
    if (motion->frame_count() != count)
      return fail(ErrorCode::InvalidArgument, motion->name(),
                  fmt::format("has {}, but {} has {}", counted(motion->frame_count(), "frame"),
                              motions[0]->name(), count),
                  "objects in one picture need equally many frames");
  }
  const std::int64_t frame = a.frame < 0 ? a.frame + count : a.frame;
  if (frame >= 0 && frame < count) return static_cast<Index>(frame);
  return fail(ErrorCode::InvalidArgument, "--frame",
              fmt::format("there is no frame {} among {}", a.frame, count),
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
  return fail(ErrorCode::InvalidArgument, "--size", fmt::format("'{}' is no size", text),
              "give pixels as WIDTHxHEIGHT, as in 1200x900");
}

Result<StepChecker> checker_of(const Objects& motions, const Poses& poses) {
  std::vector<Object> objects;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    auto built = FOLDPROOF_TRY(Hierarchy::build(motions[i]->topology(), poses.objects[i]));
    objects.emplace_back(std::move(built));
  }
  return StepChecker(std::move(objects));
}

/// Colors the faces that collide in an answer, over previous colors.
template <class Answer>
void mark(const Objects& motions, const Answer& answer, Color color, Colored& out) {
  out.faces.resize(motions.size());
  for (Index object = 0; object < motions.size(); ++object) {
    const auto marks = colliding_faces(motions[object]->topology(), object, answer);
    out.faces[object].resize(marks.size(), colors::kClay);
    for (std::size_t face = 0; face < marks.size(); ++face)
      if (marks[face]) out.faces[object][face] = color;
  }
}

Result<StaticResult> color_crossings(StepChecker& checker, const Objects& motions, Index frame,
                                     Colored& out) {
  StaticResult answer;
  FOLDPROOF_TRY(checker.check_static(out.poses.spans(), {}, answer));
  mark(motions, answer, colors::kPink, out);
  out.summary =
      fmt::format("{} of triangles in frame {}", counted(answer.crossing_count, "crossing pair"), frame);
  return answer;
}

Result<ContactFinder> finder_of(const Objects& motions) {
  std::vector<const Topology*> topologies;
  for (const auto& motion : motions) topologies.push_back(&motion->topology());
  return ContactFinder::make(std::move(topologies));
}

std::vector<Contact> worst_first(ContactFinder& finder) {
  std::vector<Contact> contacts = finder.finish();
  std::sort(contacts.begin(), contacts.end(), is_worse);
  return contacts;
}

Result<void> color_contacts(const Objects& motions, Index frame, Colored& out) {
  auto checker = FOLDPROOF_TRY(checker_of(motions, out.poses));
  StaticResult answer;
  FOLDPROOF_TRY(checker.check_static(out.poses.spans(), {}, answer));
  auto finder = FOLDPROOF_TRY(finder_of(motions));
  finder.start(frame, out.poses.spans(), answer);
  out.contacts = worst_first(finder);
  for (const auto& motion : motions)
    out.faces.emplace_back(motion->topology().triangles().size(), colors::kClay);
  for (const Contact& contact : out.contacts) {
    for (std::size_t side = 0; side < 2; ++side) {
      for (const Index triangle : contact.sides[side].triangles)
        out.faces[contact.sides[side].object][triangle] = kSideColors[side];
    }
  }
  out.summary = fmt::format("{} in frame {}", counted(out.contacts.size(), "contact"), frame);
  if (!out.contacts.empty() && out.contacts[0].depth())
    out.summary += fmt::format(", the worst {:.3g} deep", *out.contacts[0].depth());
  return {};
}

Result<void> color_collisions(const Objects& motions, Index frame, Colored& out) {
  auto checker = FOLDPROOF_TRY(checker_of(motions, out.poses));
  const auto crossings = FOLDPROOF_TRY(color_crossings(checker, motions, frame, out));
  auto finder = FOLDPROOF_TRY(finder_of(motions));
  finder.start(frame, out.poses.spans(), crossings);
  if (frame + 1 == motions[0]->frame_count()) {
    out.contacts = worst_first(finder);
    return {};
  }
  const auto next = FOLDPROOF_TRY(read(motions, frame + 1));
  StepResult answer;
  FOLDPROOF_TRY(checker.check(out.poses.spans(), next.spans(), {}, answer));
  finder.step(frame, frame + 1, out.poses.spans(), next.spans(), answer);
  out.contacts = worst_first(finder);
  mark(motions, answer, colors::kRed, out);
  const std::uint64_t pairs = answer.count();
  out.summary += fmt::format("; {} on the way to the next", counted(pairs, "colliding pair"));
  if (pairs == 0) return {};
  out.summary += fmt::format(", the first {:.4f} of the way", answer.earliest_toi);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    std::vector<double>& x = out.poses.objects[i];
    for (std::size_t k = 0; k < x.size(); ++k)
      x[k] = std::lerp(x[k], next.objects[i][k], answer.earliest_toi);
  }
  return {};
}

Result<Colored> color(const RenderArguments& a, const Objects& motions) {
  const auto frame = FOLDPROOF_TRY(frame_of(a, motions));
  auto poses = FOLDPROOF_TRY(read(motions, frame));
  Colored out{.poses = std::move(poses), .faces = {}, .contacts = {}, .summary = {}};
  if (a.color == "collisions") {
    FOLDPROOF_TRY(color_collisions(motions, frame, out));
  } else if (a.color == "contacts") {
    FOLDPROOF_TRY(color_contacts(motions, frame, out));
  }
  return out;
}

/// The meshes of a picture.
std::vector<PictureMesh> meshes_of(const RenderArguments& a, const Objects& motions, const Colored& colored) {
  std::vector<PictureMesh> meshes;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    PictureMesh mesh{.topology = &motions[i]->topology(), .positions = colored.poses.objects[i]};
    if (!colored.faces.empty()) mesh.face_colors = colored.faces[i];
    mesh.smooth = !a.flat;
    meshes.push_back(mesh);
  }
  return meshes;
}

/// The view of the worst contact.
Result<View> view_of_worst(const Colored& colored, std::span<const PictureMesh> meshes, Up up) {
  const Contact& worst = colored.contacts.front();
  std::vector<std::vector<std::uint8_t>> marked;
  for (const auto& faces : colored.faces) {
    auto& marks = marked.emplace_back(faces.size(), 0);
    // What only touches has no triangles of its own.
    for (std::size_t t = 0; worst.frames.empty() && t < faces.size(); ++t)
      marks[t] = faces[t] != colors::kClay;
  }
  for (const Contact::Side& side : worst.sides) {
    for (const Index triangle : side.triangles) marked[side.object][triangle] = 1;
  }
  return view_of(meshes, marked, worst.normal, up);
}

Result<View> view_for(const RenderArguments& a, const Objects& motions, const Colored& colored,
                      std::span<const PictureMesh> meshes) {
  auto extent = FOLDPROOF_TRY(extent_of(motions));
  if (a.up != "auto") extent.up = a.up == "y" ? Up::Y : Up::Z;
  if (a.view == "auto" && !colored.contacts.empty()) return view_of_worst(colored, meshes, extent.up);
  View view = a.view == "auto" ? default_view(extent.up) : FOLDPROOF_TRY(parse_view(a.view, extent.up));
  for (const auto& x : colored.poses.objects) extent.box.extend(box_of(x));
  view.fit = extent.box;
  return view;
}

void add_curves(const Colored& colored, Panel& panel) {
  Eigen::AlignedBox3d box;
  for (const auto& x : colored.poses.objects) box.extend(box_of(x));
  constexpr double kDot = 0.003;
  for (const Contact& contact : colored.contacts) {
    panel.points.push_back(dots_along(contact, kDot * box.sizes().maxCoeff()));
    panel.points.back().size = kDot;
  }
}

int report_interrupted() {
  print_error({"interrupted", "the picture was not finished", "nothing was written"});
  return kExitInterrupted;
}

Result<int> render(const RenderArguments& a) {
  if (a.view != "auto") {
    FOLDPROOF_TRY(parse_view(a.view));
  }
  const auto size = FOLDPROOF_TRY(size_of(a.size));
  FOLDPROOF_TRY(require_number("--fps", a.read.fps, false));
  FOLDPROOF_TRY(a.files.check());
  const auto motions = FOLDPROOF_TRY(read_motions(a.motions, a.read, a.quiet));
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  const auto colored = color(a, motions);
  if (interrupted) return report_interrupted();
  if (!colored) return tl::unexpected(colored.error());

  Panel panel{.meshes = meshes_of(a, motions, *colored)};
  panel.view = FOLDPROOF_TRY(view_for(a, motions, *colored, panel.meshes));
  if (a.color == "contacts") add_curves(*colored, panel);
  const auto image = FOLDPROOF_TRY(draw_picture(std::span(&panel, 1), {.width = size[0], .height = size[1]}));
  if (interrupted) return report_interrupted();
  FOLDPROOF_TRY(write_png(a.picture, image));
  if (!a.quiet && !colored->summary.empty()) print_output(colored->summary + "\n");
  return kExitClean;
}

}  // namespace

Command add_render(CommandLine& program) {
  const Subcommand command =
      program.add_subcommand("render", "Draw a frame into a PNG file; no display is needed");
  command.footer(std::string(kMotionHelp) + kRenderFooter);
  const auto a = std::make_shared<RenderArguments>();
  FileArguments& files = a->files;
  files.reads(command.add_option("MOTION", a->motions, "What to draw (see below)")).type_name("").required();
  files
      .writes(command.add_option("-o,--output", a->picture, "The picture to write"),
              FileArguments::Output::File, {".png"})
      .type_name("FILE")
      .required();
  command.add_option("--frame", a->frame, "The frame; negative ones count from the end [0]").type_name("K");
  command.add_option("--color", a->color, "What colors say (see below) [plain]")
      .one_of({"plain", "collisions", "contacts"});
  command
      .add_option("--view", a->view,
                  "auto, front, back, side, top, or the direction to the eye as x,y,z (see below) [auto]")
      .type_name("VIEW");
  command.add_option("--up", a->up, "The axis that points up (see below) [auto]").one_of({"auto", "y", "z"});
  command.add_option("--size", a->size, "In pixels [1200x900]").type_name("WxH");
  command.add_flag("--flat", a->flat, "Flat shading");
  command.add_option("--fps", a->read.fps, "Sampling rate for animated glTF, frames per second [24]")
      .type_name("RATE");
  command.add_option("--clip", a->read.clip, "The animation of a glTF, by its name [the longest]")
      .type_name("NAME");
  add_weld_options(command, a->read);
  command.add_flag("--points", a->read.points, "Vertices in no face and no line are points");
  command.add_flag("-q,--quiet", a->quiet, "Print nothing but errors");
  return [a] { return render(*a); };
}

}  // namespace foldproof
