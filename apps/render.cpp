#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/try.h"
#include "commands.h"
#include "options.h"
#include "report/contact_pictures.h"
#include "report/verdict.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kRenderFooter = R"(  pose.obj                        a single pose
Several motions are several objects in one picture. The camera is fitted to the whole motion, so that pictures of its
frames go together. The axis that points up is y for glTF. For other files it is guessed: z if the motion stands on
a ground across z, else y. --up sets it.

Views of --view:
  auto          with --color collisions or contacts, the worst contact with the objects around it, from the side: from
                where both of its surfaces and its curve are seen. Else from the front, slightly from the right and above
  front, back, side, top, or the direction from the objects to the eye as x,y,z

Colors of --color:
  plain         none
  collisions    red: faces that cross others or are inside them in this frame; pink: faces that meet others on the way
                to the next. If there are only those, they are drawn in the pose of the first contact
  contacts      what is inside what in this frame, or crosses it: one side of each contact is red, the other blue; the
                curves in which they cross are black. If the worst is small, it is also drawn from near

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
  bool crosses = false;                   ///< In the frame; else they touch on the way to the next.
  std::uint64_t meets = 0;                ///< Pairs that collide on that way, the first at `toi` of it.
  double toi = 0;
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

/// Colors the marked faces of an object, over previous colors.
void color_faces(std::span<const std::uint8_t> marks, Color color, std::vector<Color>& faces) {
  faces.resize(marks.size(), colors::kClay);
  for (std::size_t face = 0; face < marks.size(); ++face)
    if (marks[face]) faces[face] = color;
}

Result<ContactFinder> finder_of(const Objects& motions) {
  std::vector<const Topology*> topologies;
  Parts parts;
  for (const auto& motion : motions) {
    topologies.push_back(&motion->topology());
    parts.emplace_back(motion->info().parts.of_triangle);
  }
  return ContactFinder::make(std::move(topologies), std::move(parts));
}

std::vector<Contact> worst_first(ContactFinder& finder) {
  std::vector<Contact> contacts = finder.finish();
  std::sort(contacts.begin(), contacts.end(), is_worse);
  return contacts;
}

/// What crosses and is inside in the frame, with which `finder` has begun.
struct FrameAnswer {
  StepChecker checker;
  StaticResult crossings;
  ContactFinder finder;
};

Result<FrameAnswer> answer_for(const Objects& motions, Index frame, Colored& out) {
  auto checker = FOLDPROOF_TRY(checker_of(motions, out.poses));
  auto finder = FOLDPROOF_TRY(finder_of(motions));
  FrameAnswer answer{std::move(checker), {}, std::move(finder)};
  FOLDPROOF_TRY(answer.checker.check_static(out.poses.spans(), {}, answer.crossings));
  answer.finder.start(frame, out.poses.spans(), answer.crossings);
  out.crosses = answer.crossings.crossing_count > 0;
  return answer;
}

Result<void> color_contacts(const Objects& motions, Index frame, Colored& out) {
  auto answer = FOLDPROOF_TRY(answer_for(motions, frame, out));
  out.contacts = worst_first(answer.finder);
  for (const auto& motion : motions)
    out.faces.emplace_back(motion->topology().triangles().size(), colors::kClay);
  for (const Contact& contact : out.contacts) {
    for (std::size_t side = 0; side < 2; ++side) {
      for (const Index triangle : contact.sides[side].triangles)
        out.faces[contact.sides[side].object][triangle] = kSideColors[side];
    }
  }
  return {};
}

Result<void> color_collisions(const Objects& motions, Index frame, Colored& out) {
  auto [checker, crossings, finder] = FOLDPROOF_TRY(answer_for(motions, frame, out));
  CheckedStep pose;
  pose.pose = &crossings;
  pose.contacts = &finder;
  std::vector<std::vector<std::uint8_t>> inside;
  for (Index i = 0; i < motions.size(); ++i) inside.push_back(*inside_faces(motions[i]->topology(), i, pose));
  out.faces.resize(motions.size());
  StepResult answer;
  if (frame + 1 < motions[0]->frame_count()) {
    const auto next = FOLDPROOF_TRY(read(motions, frame + 1));
    FOLDPROOF_TRY(checker.check(out.poses.spans(), next.spans(), {}, answer));
    out.meets = answer.count();
    out.toi = answer.earliest_toi;
    if (out.meets > 0 && !out.crosses) {
      finder.step(frame, frame + 1, out.poses.spans(), next.spans(), answer);
      for (std::size_t i = 0; i < motions.size(); ++i) {
        std::vector<double>& x = out.poses.objects[i];
        for (std::size_t k = 0; k < x.size(); ++k)
          x[k] = std::lerp(x[k], next.objects[i][k], answer.earliest_toi);
      }
    }
  }
  for (Index i = 0; i < motions.size(); ++i) {
    color_faces(colliding_faces(motions[i]->topology(), i, answer), colors::kPink, out.faces[i]);
    color_faces(inside[i], colors::kRed, out.faces[i]);
  }
  out.contacts = worst_first(finder);
  return {};
}

/// What is in the picture, in a sentence.
std::string sentence_about(const Objects& motions, Index frame, const Colored& colored) {
  CheckTotals totals;
  totals.first_frame = totals.last_frame = frame;
  totals.contacts = colored.contacts;
  std::string text = colored.crosses ? contact_sentence(motions, {}, totals).text()
                                     : fmt::format("Nothing crosses in frame {}", frame);
  if (colored.meets > 0)
    text += fmt::format("; {} on the way to the next, the first {:.4g} of the way",
                        counted(colored.meets, "colliding pair"), colored.toi);
  return text + ".";
}

Result<Colored> color(const RenderArguments& a, const Objects& motions) {
  const auto frame = FOLDPROOF_TRY(frame_of(a, motions));
  auto poses = FOLDPROOF_TRY(read(motions, frame));
  Colored out{.poses = std::move(poses), .faces = {}, .contacts = {}, .summary = {}};
  if (a.color == "plain") return out;
  if (a.color == "collisions") {
    FOLDPROOF_TRY(color_collisions(motions, frame, out));
  } else if (a.color == "contacts") {
    FOLDPROOF_TRY(color_contacts(motions, frame, out));
  }
  out.summary = sentence_about(motions, frame, out);
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
  ContactMarks marks = marks_of(worst, meshes);
  // What only touches has no triangles of its own.
  for (std::size_t i = 0; worst.frames.empty() && i < meshes.size(); ++i) {
    for (std::size_t t = 0; t < marks[i].size(); ++t) marks[i][t] = colored.faces[i][t] != colors::kClay;
  }
  return view_of(meshes, marks, worst.curves, worst.normal, up);
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

/// The curves, and the worst contact once more, from near, where it is small.
std::vector<Panel> with_contacts(Panel whole, const Colored& colored, bool near) {
  Eigen::AlignedBox3d box;
  for (const auto& x : colored.poses.objects) box.extend(box_of(x));
  const double size = box.sizes().maxCoeff();
  for (const Contact& contact : colored.contacts) {
    const double dot = std::min(kDot, thin_dot(contact, size));
    whole.points.push_back(dots_along(contact, dot * size));
    whole.points.back().size = dot;
  }
  std::vector<Panel> panels{whole};
  const auto focus =
      near && !colored.contacts.empty() ? focus_on(colored.contacts.front(), size) : std::nullopt;
  if (!focus) return panels;
  panels.push_back(std::move(whole));
  panels.back().view.focus = focus;
  return panels;
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
  std::vector<Panel> panels{panel};
  if (a.color == "contacts") panels = with_contacts(std::move(panel), *colored, a.view == "auto");
  const auto image = FOLDPROOF_TRY(draw_picture(panels, {.width = size[0], .height = size[1]}));
  if (interrupted) return report_interrupted();
  FOLDPROOF_TRY(write_png(a.picture, image));
  if (!a.quiet && !colored->summary.empty()) print_output(printable(colored->summary) + "\n");
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
