#include <algorithm>
#include <limits>
#include <map>
#include <tuple>

#include "base/parallel.h"
#include "base/plain_arithmetic.h"
#include "check/motion.h"
#include "contacts/follow_crossings.h"
#include "contacts/frame.h"
#include "contacts/joiner.h"
#include "contacts/scaled.h"
#include "foldproof/contacts.h"

namespace foldproof {
namespace {

// A contact that may go on.
struct Open {
  Contact contact;
  bool continues = false;                                         // in this slice
  bool crosses = false;                                           // in the last frame
  double first_impact = std::numeric_limits<double>::infinity();  // whose place `point` is without frames
  std::array<std::map<Index, std::uint64_t>, 2> votes;            // triangles per part
  bool of_faces = false, pierces = false;  // two faces meet; a face and a line or point
};

// A contact in a frame.
struct InFrame {
  Open* open = nullptr;
  std::vector<CrossingPair> pairs;
  std::array<std::vector<Index>, 2> inside = {};  // triangles, per side
};

// A step, or the first frame, for which begin is end.
struct Slice {
  double begin, end;
  Positions x0, x1;
  const StepResult& step;
};

void swap_sides(Open& open) {
  std::swap(open.contact.sides[0], open.contact.sides[1]);
  std::swap(open.votes[0], open.votes[1]);
  open.contact.normal = -open.contact.normal;
  for (ContactFrame& frame : open.contact.frames) std::swap(frame.area[0], frame.area[1]);
}

bool is_worse_frame(const ContactFrame& a, const ContactFrame& b) {
  const auto key = [](const ContactFrame& f) {
    return std::tuple(f.severity(), !f.touching, f.curve_length);
  };
  return key(a) > key(b);
}

// Frames of two contacts that have joined: those of the same time are one, as bad as the worse.
std::vector<ContactFrame> joined_frames(const std::vector<ContactFrame>& a,
                                        const std::vector<ContactFrame>& b) {
  std::vector<ContactFrame> out;
  for (std::size_t i = 0, k = 0; i < a.size() || k < b.size();) {
    if (k == b.size() || (i < a.size() && a[i].time < b[k].time)) {
      out.push_back(a[i++]);
    } else if (i == a.size() || b[k].time < a[i].time) {
      out.push_back(b[k++]);
    } else {
      ContactFrame frame = is_worse_frame(b[k], a[i]) ? b[k] : a[i];
      frame.crossings = a[i].crossings + b[k].crossings;
      frame.triangles = a[i].triangles + b[k].triangles;
      frame.curve_length = a[i].curve_length + b[k].curve_length;
      frame.closed = a[i].closed && b[k].closed;
      for (int side = 0; side < 2; ++side) {
        const auto &p = a[i].area[side], &q = b[k].area[side];
        frame.area[side] = p && q ? std::optional(*p + *q) : std::nullopt;
      }
      out.push_back(frame);
      ++i, ++k;
    }
  }
  return out;
}

}  // namespace

bool is_worse(const Contact& a, const Contact& b) {
  const auto key = [](const Contact& c) {
    return std::tuple(c.frames.empty() ? -1.0 : c.frames[c.worst].severity(), !c.touching(), c.pairs);
  };
  if (key(a) != key(b)) return key(a) > key(b);
  return a.number < b.number;
}

struct ContactFinder::Impl {
  Impl(std::vector<const Topology*> topologies, Parts all_parts, std::shared_ptr<const PairFilter> pairs)
      : surfaces(std::move(topologies)),
        parts(std::move(all_parts)),
        filter(std::move(pairs)),
        measurers([this] { return FrameMeasurer(surfaces); }) {}

  void set_crossings(const StaticResult& all);
  void step(double begin, double end, Positions x0, Positions x1, const StepResult& step,
            const StaticResult* all);
  void run(const Slice& slice);
  void add_elements(const StepResult& step);
  std::array<Index, 2> objects_of(std::size_t element, const StepResult& step) const;
  double time_of(std::size_t element, const Slice& slice) const;
  Vec3 place_of(std::size_t element, const Slice& slice) const;
  void name_groups(const Joiner::Groups& groups, const Slice& slice);
  std::array<bool, 2> faces_of(std::size_t element, const StepResult& step) const;
  void note_elements(const Joiner::Groups& groups, const Slice& slice);
  void vote(Open& open, int side, Index object, Index triangle);
  void measure_frame(double now, Positions x);
  void measure_contact(InFrame& frame, double now, const Scaled& x);
  void name_part(Open& of, int side) const;
  void end_contacts(bool all);
  Label resolve(Label label) const;
  void join(Label a, Label b);

  Surfaces surfaces;
  Parts parts;
  std::shared_ptr<const PairFilter> filter;
  Joiner joiner{surfaces};
  PerThread<FrameMeasurer> measurers;

  bool begun = false, known = false;
  double time = 0;
  std::vector<TriangleCrossing> crossings, tested;
  std::map<Index, Open> open;
  std::vector<Label> joined{{}};  // per number: the contact that it has joined; itself if none
  std::vector<Contact> ended;

  // Of this slice, per element: vertex-face, then edge-edge pairs, then crossings.
  std::size_t vertex_faces = 0, edge_edges = 0;
  std::vector<Label> labels;   // per group
  std::vector<Open*> opens;    // per group
  std::vector<Index> numbers;  // per element
  std::vector<Inside> inside;
};

void ContactFinder::Impl::add_elements(const StepResult& step) {
  vertex_faces = step.vertex_face.size();
  edge_edges = step.edge_edge.size();
  numbers.resize(vertex_faces + edge_edges + crossings.size());
  joiner.begin(numbers.size());
  for (const VertexFaceCollision& c : step.vertex_face) {
    joiner.add(surfaces.vertex(c.vertex_object, c.vertex), surfaces.triangle(c.face_object, c.face),
               surfaces.corners(c.face_object, c.face));
  }
  for (const EdgeEdgeCollision& c : step.edge_edge) {
    const Edge a{surfaces.vertex(c.object_a, c.a[0]), surfaces.vertex(c.object_a, c.a[1])},
        b{surfaces.vertex(c.object_b, c.b[0]), surfaces.vertex(c.object_b, c.b[1])};
    joiner.add(a, b);
  }
  for (const TriangleCrossing& c : crossings) {
    joiner.add(surfaces.corners(c.object_a, c.triangle_a), surfaces.corners(c.object_b, c.triangle_b));
  }
}

std::array<Index, 2> ContactFinder::Impl::objects_of(std::size_t element, const StepResult& step) const {
  if (element < vertex_faces)
    return {step.vertex_face[element].vertex_object, step.vertex_face[element].face_object};
  if (element < vertex_faces + edge_edges) {
    const EdgeEdgeCollision& c = step.edge_edge[element - vertex_faces];
    return {c.object_a, c.object_b};
  }
  const TriangleCrossing& c = crossings[element - vertex_faces - edge_edges];
  return {c.object_a, c.object_b};
}

// Of its first impact; infinity for a crossing.
double ContactFinder::Impl::time_of(std::size_t element, const Slice& slice) const {
  if (element >= vertex_faces + edge_edges) return std::numeric_limits<double>::infinity();
  const double toi = element < vertex_faces ? slice.step.vertex_face[element].toi
                                            : slice.step.edge_edge[element - vertex_faces].toi;
  return slice.begin + toi * (slice.end - slice.begin);
}

// Where the first impact of two features is.
Vec3 ContactFinder::Impl::place_of(std::size_t element, const Slice& slice) const {
  const auto at = [&](Index object, Index vertex, double toi) -> Vec3 {
    return (1 - toi) * position(slice.x0[object], vertex) + toi * position(slice.x1[object], vertex);
  };
  if (element < vertex_faces) {
    const VertexFaceCollision& c = slice.step.vertex_face[element];
    return at(c.vertex_object, c.vertex, c.toi);
  }
  const EdgeEdgeCollision& c = slice.step.edge_edge[element - vertex_faces];
  // Quarters, as the sum could overflow.
  return at(c.object_a, c.a[0], c.toi) / 4 + at(c.object_a, c.a[1], c.toi) / 4 +
         at(c.object_b, c.b[0], c.toi) / 4 + at(c.object_b, c.b[1], c.toi) / 4;
}

Label ContactFinder::Impl::resolve(Label label) const {
  while (joined[label.number].number != label.number) {
    const Label next = joined[label.number];
    label = {next.number, label.reversed != next.reversed};
  }
  return label;
}

// Two labels of one group: their contacts are one from now on.
void ContactFinder::Impl::join(Label a, Label b) {
  a = resolve(a);
  b = resolve(b);
  if (a.number == b.number) {
    if (a.reversed != b.reversed) open.at(a.number).contact.folded = true;
    return;
  }
  if (b.number < a.number) std::swap(a, b);
  const bool reversed = a.reversed != b.reversed;
  joined[b.number] = {a.number, reversed};
  Open &into = open.at(a.number), &from = open.at(b.number);
  if (reversed) swap_sides(from);
  Contact &c = into.contact, &other = from.contact;
  const bool touch_only = c.frames.empty() && other.frames.empty();
  const bool other_is_worse = touch_only ? from.first_impact < into.first_impact : is_worse(other, c);
  into.first_impact = std::min(into.first_impact, from.first_impact);
  const double worst_time = [&] {
    const Contact& worse = other_is_worse ? other : c;
    return worse.frames.empty() ? 0.0 : worse.frames[worse.worst].time;
  }();
  std::vector<ContactFrame> frames = joined_frames(c.frames, other.frames);
  if (other_is_worse) {
    c.sides = std::move(other.sides);
    c.point = other.point;
    c.low = other.low;
    c.high = other.high;
    c.normal = other.normal;
    c.curves = std::move(other.curves);
  }
  c.frames = std::move(frames);
  c.worst = 0;
  for (std::size_t i = 0; i < c.frames.size(); ++i) {
    if (c.frames[i].time == worst_time) c.worst = i;
  }
  c.joined.push_back(b.number);
  c.joined.insert(c.joined.end(), other.joined.begin(), other.joined.end());
  std::sort(c.joined.begin(), c.joined.end());
  c.folded |= other.folded;
  c.from_start |= other.from_start;
  c.first_time = std::min(c.first_time, other.first_time);
  c.last_time = std::max(c.last_time, other.last_time);
  c.pairs += other.pairs;
  into.of_faces |= from.of_faces;
  into.pierces |= from.pierces;
  for (int side = 0; side < 2; ++side) {
    for (const auto& [part, count] : from.votes[side]) into.votes[side][part] += count;
  }
  open.erase(b.number);
}

// Gives every group the contact that it continues, or a new one.
void ContactFinder::Impl::name_groups(const Joiner::Groups& groups, const Slice& slice) {
  const std::size_t count = groups.labels.size();
  labels.assign(count, {});
  std::vector<double> first(count, std::numeric_limits<double>::infinity());
  std::vector<std::size_t> first_element(count, numbers.size());
  for (std::size_t e = numbers.size(); e-- > 0;) {
    const Index g = groups.group[e];
    first[g] = std::min(first[g], time_of(e, slice));
    first_element[g] = e;
  }
  std::vector<std::size_t> fresh;
  for (std::size_t g = 0; g < count; ++g) {
    const auto& old = groups.labels[g];
    if (old.empty()) fresh.push_back(g);
    for (std::size_t i = 1; i < old.size(); ++i) join(old[0], old[i]);
  }
  std::stable_sort(fresh.begin(), fresh.end(),
                   [&](std::size_t a, std::size_t b) { return first[a] < first[b]; });
  for (const std::size_t g : fresh) {
    const auto number = static_cast<Index>(joined.size());
    const std::array<Index, 2> of = objects_of(first_element[g], slice.step);
    const bool reversed = of[1] < of[0];
    joined.push_back({number, false});
    labels[g] = {number, reversed};
    Open& made = open[number];
    made.contact.number = number;
    for (int side = 0; side < 2; ++side) made.contact.sides[side].object = of[reversed ? 1 - side : side];
    made.contact.from_start = !begun;
    made.contact.first_time = made.contact.last_time = begun ? std::min(first[g], time) : time;
  }
  opens.resize(count);
  for (std::size_t g = 0; g < count; ++g) {
    if (!groups.labels[g].empty()) labels[g] = resolve(groups.labels[g][0]);
    opens[g] = &open.at(labels[g].number);
    Open& it = *opens[g];
    it.contact.folded |= groups.folded[g] != 0;
    it.continues = true;
  }
}

void ContactFinder::Impl::vote(Open& to, int side, Index object, Index triangle) {
  if (object < parts.size() && !parts[object].empty()) ++to.votes[side][parts[object][triangle]];
}

// Whether the features or triangles of an element are of faces.
std::array<bool, 2> ContactFinder::Impl::faces_of(std::size_t element, const StepResult& step) const {
  if (element < vertex_faces) {
    const VertexFaceCollision& c = step.vertex_face[element];
    return {surfaces.is_of_face(c.vertex_object, c.vertex), surfaces.is_face(c.face_object, c.face)};
  }
  if (element < vertex_faces + edge_edges) {
    const EdgeEdgeCollision& c = step.edge_edge[element - vertex_faces];
    return {surfaces.is_of_face(c.object_a, c.a), surfaces.is_of_face(c.object_b, c.b)};
  }
  const TriangleCrossing& c = crossings[element - vertex_faces - edge_edges];
  return {surfaces.is_face(c.object_a, c.triangle_a), surfaces.is_face(c.object_b, c.triangle_b)};
}

void ContactFinder::Impl::note_elements(const Joiner::Groups& groups, const Slice& slice) {
  const StepResult& step = slice.step;
  for (std::size_t e = 0; e < numbers.size(); ++e) {
    const Label& label = labels[groups.group[e]];
    numbers[e] = label.number;
    Open& to = *opens[groups.group[e]];
    Contact& c = to.contact;
    const bool reversed = label.reversed != static_cast<bool>(groups.reversed[e]);
    const int first = reversed ? 1 : 0;
    if (e < vertex_faces + edge_edges) {
      ++c.pairs;
      const double impact = time_of(e, slice);
      if (c.frames.empty() && impact < to.first_impact) {
        to.first_impact = impact;
        c.point = c.low = c.high = place_of(e, slice);
      }
      c.first_time = c.from_start ? c.first_time : std::min(c.first_time, impact);
      c.last_time = std::max(c.last_time, impact);
    }
    const std::array<bool, 2> face = faces_of(e, step);
    to.of_faces |= face[0] && face[1];
    to.pierces |= face[0] != face[1];
    if (e < vertex_faces) {
      const VertexFaceCollision& pair = step.vertex_face[e];
      vote(to, first, pair.vertex_object, surfaces.triangles_at(pair.vertex_object, pair.vertex).front());
      vote(to, 1 - first, pair.face_object, pair.face);
    } else if (e >= vertex_faces + edge_edges) {
      const TriangleCrossing& pair = crossings[e - vertex_faces - edge_edges];
      vote(to, first, pair.object_a, pair.triangle_a);
      vote(to, 1 - first, pair.object_b, pair.triangle_b);
    }
  }
}

void ContactFinder::Impl::measure_contact(InFrame& of, double now, const Scaled& x) {
  FrameMeasurer& measurer = measurers.local();
  Contact& c = of.open->contact;
  ContactFrame frame;
  measurer.measure(of.pairs, c.folded, x.positions(), frame);
  x.restore(frame);
  for (int side = 0; side < 2; ++side)
    of.inside[side].assign(measurer.inside(side).begin(), measurer.inside(side).end());
  if (!c.frames.empty() && c.frames.back().time == now) return;  // a single pose, as a step that stands still
  frame.time = now;
  c.last_time = std::max(c.last_time, now);
  c.frames.push_back(frame);
  if (c.frames.size() > 1 && !is_worse_frame(frame, c.frames[c.worst])) return;
  c.worst = c.frames.size() - 1;
  measurer.describe(of.pairs, x.positions(), c);
  x.restore(c);
}

void ContactFinder::Impl::measure_frame(double now, Positions x) {
  for (auto& [number, it] : open) it.crosses = false;
  const Joiner::Groups& groups = joiner.groups();
  const std::size_t begin = vertex_faces + edge_edges;
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::map<Index, std::size_t> places;                      // in all, by number
  std::vector<std::size_t> place_of(labels.size(), kNone);  // by group
  std::vector<InFrame> all;
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    const Index group = groups.group[begin + i];
    if (place_of[group] == kNone) {
      const auto [place, is_new] = places.try_emplace(labels[group].number, all.size());
      if (is_new) all.push_back({opens[group], {}});
      place_of[group] = place->second;
    }
    all[place_of[group]].pairs.push_back(
        {crossings[i], labels[group].reversed != static_cast<bool>(groups.reversed[begin + i])});
  }
  inside.clear();
  if (all.empty()) return;
  const Scaled scaled(x);
  parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) { measure_contact(all[i], now, scaled); });
  for (const auto& [number, place] : places) {
    all[place].open->crosses = true;
    for (int side = 0; side < 2; ++side) {
      const Index object = all[place].open->contact.sides[side].object;
      for (const Index t : all[place].inside[side]) inside.push_back({object, t, number});
    }
  }
}

// The part of most triangles of a side in the worst frame; of what only touches, of most that took part.
void ContactFinder::Impl::name_part(Open& of, int side) const {
  Contact::Side& it = of.contact.sides[side];
  if (it.object >= parts.size() || parts[it.object].empty()) return;
  std::map<Index, std::uint64_t> counts;
  for (const Index t : it.triangles) ++counts[parts[it.object][t]];
  std::uint64_t most = 0;
  for (const auto& [part, count] : counts.empty() ? of.votes[side] : counts) {
    if (count > most) most = count, it.part = part;
  }
}

void ContactFinder::Impl::end_contacts(bool all) {
  for (auto at = open.begin(); at != open.end();) {
    Open& it = at->second;
    if (!all && it.continues) {
      it.continues = false;
      ++at;
      continue;
    }
    it.contact.healed = !(all && it.crosses);
    it.contact.pierces = it.pierces && !it.of_faces;
    for (int side = 0; side < 2; ++side) name_part(it, side);
    if (it.contact.within() && it.contact.sides[1].part < it.contact.sides[0].part) swap_sides(it);
    ended.push_back(std::move(it.contact));
    at = open.erase(at);
  }
}

void ContactFinder::Impl::run(const Slice& slice) {
  add_elements(slice.step);
  time = slice.end;
  const Joiner::Groups& groups = joiner.find_groups();
  name_groups(groups, slice);
  note_elements(groups, slice);
  joiner.end(labels);
  measure_frame(slice.end, slice.x1);
  end_contacts(false);
  begun = true;
}

Result<ContactFinder> ContactFinder::make(std::vector<const Topology*> topologies, Parts parts,
                                          std::shared_ptr<const PairFilter> filter) {
  std::uint64_t vertices = 0, triangles = 0;
  for (const Topology* topology : topologies) {
    vertices += topology->vertex_count();
    triangles += topology->triangles().size();
  }
  if (vertices >= kNoIndex || triangles >= kNoIndex)
    return fail(ErrorCode::LimitExceeded, "objects", "have more than 2^32 - 2 vertices or triangles in all",
                "look for contacts of fewer objects at a time");
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!parts[i].empty() && (i >= topologies.size() || parts[i].size() != topologies[i]->triangles().size()))
      return fail(ErrorCode::InvalidArgument, "parts",
                  "have not one number per triangle of object " + std::to_string(i),
                  "give a part for each triangle, or none");
  }
  return ContactFinder(std::make_unique<Impl>(std::move(topologies), std::move(parts), std::move(filter)));
}

ContactFinder::ContactFinder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ContactFinder::~ContactFinder() = default;
ContactFinder::ContactFinder(ContactFinder&&) noexcept = default;
ContactFinder& ContactFinder::operator=(ContactFinder&&) noexcept = default;

void ContactFinder::Impl::set_crossings(const StaticResult& all) {
  known = all.crossings.size() == all.crossing_count;
  crossings.clear();
  if (known) crossings = all.crossings;
}

void ContactFinder::Impl::step(double begin, double end, Positions x0, Positions x1, const StepResult& step,
                               const StaticResult* all) {
  begun = true;
  known = known && step.lists_all();
  if (all) {
    set_crossings(*all);
  } else if (known) {
    follow_crossings(surfaces, filter.get(), step, x1, tested, crossings);
  } else {
    crossings.clear();
  }
  run({begin, end, x0, x1, step});
}

void ContactFinder::start(double time, Positions x, const StaticResult& crossings) {
  const PlainArithmetic plain;
  impl_->set_crossings(crossings);
  isolated([&] { impl_->run({time, time, x, x, StepResult()}); });
}

void ContactFinder::step(double begin, double end, Positions x0, Positions x1, const StepResult& step,
                         const StaticResult* crossings) {
  const PlainArithmetic plain;
  isolated([&] { impl_->step(begin, end, x0, x1, step, crossings); });
}

bool ContactFinder::is_known() const { return impl_->known; }
std::span<const TriangleCrossing> ContactFinder::crossings() const { return impl_->crossings; }
std::span<const Index> ContactFinder::vertex_face_contacts() const {
  return std::span(impl_->numbers).first(impl_->vertex_faces);
}
std::span<const Index> ContactFinder::edge_edge_contacts() const {
  return std::span(impl_->numbers).subspan(impl_->vertex_faces, impl_->edge_edges);
}
std::span<const Index> ContactFinder::crossing_contacts() const {
  return std::span(impl_->numbers).subspan(impl_->vertex_faces + impl_->edge_edges);
}
std::span<const ContactFinder::Inside> ContactFinder::inside() const { return impl_->inside; }
std::optional<double> ContactFinder::depth_now(Index number) const {
  const auto at = impl_->open.find(number);
  if (at == impl_->open.end() || !at->second.crosses) return std::nullopt;
  return at->second.contact.frames.back().depth;
}
Index ContactFinder::joined_number(Index number) const { return impl_->resolve({number, false}).number; }
std::size_t ContactFinder::open_count() const { return impl_->open.size(); }

std::vector<Contact> ContactFinder::take_ended() {
  std::vector<Contact> out;
  out.swap(impl_->ended);
  std::sort(out.begin(), out.end(), [](const Contact& a, const Contact& b) { return a.number < b.number; });
  return out;
}

std::vector<Contact> ContactFinder::finish() {
  impl_->end_contacts(true);
  return take_ended();
}

}  // namespace foldproof
