#include "page/step_store.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "base/try.h"
#include "page/contact.h"

namespace foldproof {
namespace {

constexpr const char* kWhere = "the check's answers";

template <class T>
std::span<const char> bytes_of(std::span<const T> values) {
  static_assert(std::is_trivially_copyable_v<T>, "is written as raw bytes");
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

template <class T>
std::span<char> bytes_of(std::vector<T>& values) {
  static_assert(std::is_trivially_copyable_v<T>, "is read as raw bytes");
  return {reinterpret_cast<char*>(values.data()), values.size() * sizeof(T)};
}

tl::unexpected<Error> unreadable() {
  return fail(ErrorCode::FileAccess, kWhere, "cannot be read back from the temporary file", "start again");
}

std::vector<ContactPoint> crossings_of(const CheckedStep& pose, Motions motions) {
  const auto corners = [&](Index object, Index triangle) {
    std::array<Vec3, 3> x;
    const Triangle& t = motions[object]->topology().triangles()[triangle];
    for (std::size_t k = 0; k < 3; ++k) x[k] = Vec3::load(&pose.x0[object][3 * std::size_t{t[k]}]);
    return x;
  };
  std::vector<ContactPoint> crossings;
  crossings.reserve(pose.pose->crossings.size());
  for (const TriangleCrossing& c : pose.pose->crossings) {
    const Vec3 point = crossing_point(corners(c.object_a, c.triangle_a), corners(c.object_b, c.triangle_b));
    crossings.push_back({.point = {point.x(), point.y(), point.z()},
                         .object_a = c.object_a,
                         .object_b = c.object_b,
                         .a = {c.triangle_a, 0},
                         .b = {c.triangle_b, 0},
                         .kind = PairKind::Triangles});
  }
  return crossings;
}

std::vector<ContactPoint> contacts_of(const CheckedStep& step, Motions motions) {
  if (step.pose) return crossings_of(step, motions);
  std::vector<ContactPoint> contacts;
  contacts.reserve(step.step->vertex_face.size() + step.step->edge_edge.size());
  const auto add = [&](const auto& c, ContactPoint contact, const Vec3& point) {
    contact.toi = c.toi;
    contact.answer = c.answer;
    contact.point = {point.x(), point.y(), point.z()};
    contacts.push_back(contact);
  };
  for (const VertexFaceCollision& c : step.step->vertex_face) {
    add(c,
        {.object_a = c.vertex_object,
         .object_b = c.face_object,
         .a = {c.vertex, 0},
         .b = {c.face, 0},
         .kind = PairKind::VertexFace},
        contact_point(step.x0, step.x1, c, motions[c.face_object]->topology().triangles()));
  }
  for (const EdgeEdgeCollision& c : step.step->edge_edge) {
    add(c, {.object_a = c.object_a, .object_b = c.object_b, .a = c.a, .b = c.b, .kind = PairKind::EdgeEdge},
        contact_point(step.x0, step.x1, c));
  }
  std::stable_sort(contacts.begin(), contacts.end(),
                   [](const ContactPoint& a, const ContactPoint& b) { return a.toi < b.toi; });
  return contacts;
}

Bounds bounds_of(Positions x) {
  constexpr double kMax = std::numeric_limits<double>::infinity();
  Bounds bounds{{kMax, kMax, kMax}, {-kMax, -kMax, -kMax}};
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t k = 0; k < x[i].size(); ++k) {
      bounds.low[k % 3] = std::min(bounds.low[k % 3], x[i][k]);
      bounds.high[k % 3] = std::max(bounds.high[k % 3], x[i][k]);
    }
  }
  return bounds;
}

}  // namespace

StepRecorder::Inside StepRecorder::inside_of(const CheckedStep& step) const {
  std::vector<std::vector<std::uint8_t>> all;
  for (Index i = 0; i < motions_.size(); ++i) {
    auto marks = inside_faces(motions_[i]->topology(), i, step);
    if (!marks) return std::nullopt;
    all.push_back(std::move(*marks));
  }
  return all;
}

StepRecord StepRecorder::add(const CheckedStep& step) {
  StepRecord record{.index = step.index,
                    .collisions = step.collisions,
                    .listed = step.listed().sum(),
                    .earliest_toi = step.earliest_toi,
                    .tolerance = step.step ? step.step->tolerance : 0,
                    .work = step.work,
                    .leaf_pairs = step.explanation->leaf_pairs,
                    .milliseconds = step.milliseconds};
  Inside end = inside_of(step);
  if (step.pose) inside_ = end;
  marks_.clear();
  for (Index i = 0; i < motions_.size(); ++i) {
    const Topology& topology = motions_[i]->topology();
    marks_.push_back(step.step ? colliding_faces(topology, i, *step.step)
                               : std::vector<std::uint8_t>(topology.triangles().size(), 0));
  }
  for (const std::size_t k : {0, 1}) {
    const Inside& inside = k == 0 ? inside_ : end;
    if (!inside) continue;
    record.inside[k] = 0;
    for (std::size_t i = 0; i < marks_.size(); ++i) {
      for (std::size_t t = 0; t < marks_[i].size(); ++t) {
        marks_[i][t] = static_cast<std::uint8_t>(marks_[i][t] + (2 << k) * (*inside)[i][t]);
        *record.inside[k] += (*inside)[i][t];
      }
    }
  }
  inside_ = std::move(end);
  return record;
}

StartRecord start_of(const CheckedStep& pose) {
  return {pose.index.frame, pose.collisions.triangle_triangle, pose.listed().triangle_triangle,
          pose.milliseconds};
}

Result<std::unique_ptr<StepStore>> StepStore::open(Motions motions) {
  auto entries = FOLDPROOF_TRY(io::Spool::open(kWhere));
  auto details = FOLDPROOF_TRY(io::Spool::open(kWhere));
  return std::unique_ptr<StepStore>(new StepStore(motions, std::move(entries), std::move(details)));
}

StepStore::StepStore(Motions motions, io::Spool entries, io::Spool details)
    : motions_(motions),
      first_face_{0},
      entries_(std::move(entries)),
      details_(std::move(details)),
      recorder_(motions) {
  for (const auto& motion : motions)
    first_face_.push_back(first_face_.back() + motion->topology().triangles().size());
}

Result<void> StepStore::append(std::span<const char> bytes) {
  auto done = details_.append(bytes);
  if (done) details_size_ += bytes.size();
  return done;
}

Result<void> StepStore::start(const CheckedStep& pose) {
  const std::vector<ContactPoint> crossings = crossings_of(pose, motions_);
  FOLDPROOF_TRY(append(bytes_of(std::span(crossings))));
  recorder_.start(pose);
  start_ = start_of(pose);
  started_.store(true, std::memory_order_release);
  return {};
}

std::optional<StartRecord> StepStore::started() const {
  if (!started_.load(std::memory_order_acquire)) return std::nullopt;
  return start_;
}

Result<std::vector<ContactPoint>> StepStore::crossings(std::uint64_t offset, std::uint64_t limit) const {
  offset = std::min(offset, start_.listed);
  std::vector<ContactPoint> crossings(std::min(limit, start_.listed - offset));
  if (!details_.read_at(offset * sizeof(ContactPoint), bytes_of(crossings))) return unreadable();
  return crossings;
}

Result<void> StepStore::add(const CheckedStep& step) {
  Entry entry{.record = recorder_.add(step),
              .contacts_at = details_size_,
              .faces_at = 0,
              .bounds = bounds_of(step.x1)};
  const std::vector<ContactPoint> contacts = contacts_of(step, motions_);
  FOLDPROOF_TRY(append(bytes_of(std::span(contacts))));
  entry.faces_at = details_size_;
  for (Index i = 0; i < motions_.size(); ++i) {
    const std::vector<std::uint8_t>& marks = recorder_.marks()[i];
    const Explanation::Object& why = step.explanation->objects[i];
    std::vector<FaceRecord> faces(marks.size());
    for (std::size_t t = 0; t < faces.size(); ++t) {
      faces[t] = {marks[t], static_cast<std::uint8_t>(why.reason[t]), why.level[t],
                  static_cast<std::uint8_t>(std::lround(255 * why.margin[t]))};
    }
    FOLDPROOF_TRY(append(bytes_of(std::span<const FaceRecord>(faces))));
  }
  FOLDPROOF_TRY(entries_.append(bytes_of(std::span<const Entry>(&entry, 1))));
  count_.fetch_add(1, std::memory_order_release);
  return {};
}

Result<StepStore::Entry> StepStore::entry(std::uint64_t number) const {
  std::vector<Entry> entry(1);
  if (!entries_.read_at(number * sizeof(Entry), bytes_of(entry))) return unreadable();
  return entry[0];
}

Result<StepRecord> StepStore::record(std::uint64_t number) const {
  const auto found = FOLDPROOF_TRY(entry(number));
  return found.record;
}

Result<Bounds> StepStore::bounds(std::uint64_t number) const {
  const auto found = FOLDPROOF_TRY(entry(number));
  return found.bounds;
}

Result<std::vector<ContactPoint>> StepStore::contacts(std::uint64_t number, std::uint64_t offset,
                                                      std::uint64_t limit) const {
  const auto found = FOLDPROOF_TRY(entry(number));
  const std::uint64_t all = found.record.listed;
  offset = std::min(offset, all);
  std::vector<ContactPoint> contacts(std::min(limit, all - offset));
  if (!details_.read_at(found.contacts_at + offset * sizeof(ContactPoint), bytes_of(contacts)))
    return unreadable();
  return contacts;
}

Result<std::vector<FaceRecord>> StepStore::faces(std::uint64_t number, Index object) const {
  const auto found = FOLDPROOF_TRY(entry(number));
  std::vector<FaceRecord> faces(first_face_[object + 1] - first_face_[object]);
  const std::uint64_t at = found.faces_at + first_face_[object] * sizeof(FaceRecord);
  if (!details_.read_at(at, bytes_of(faces))) return unreadable();
  return faces;
}

}  // namespace foldproof
