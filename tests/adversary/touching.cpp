#include "adversary/touching.h"

#include <fmt/format.h>

#include <algorithm>

#include "adversary/run.h"
#include "adversary/touching_pairs.h"
#include "oracle/one_target.h"

namespace foldproof::adversary {
namespace {

constexpr int kContacts = 100, kFlatPairs = 10;

// They come as near as that at the end of a step, at its begin or all the time.
std::string ask_contact(Source& source) {
  const unsigned how = source.pick(16);
  const Contact c = how == 0  ? make_thin_contact(source)
                    : how < 4 ? make_tiny_contact(source)
                              : make_contact(source);
  const bool edges = c.kind == oracle::Kind::EdgeEdge;
  Features pair{c.kind, c.points, c.points};
  CcdSettings settings;
  settings.thickness = c.thickness;
  const double size = std::max(1.0, (c.points[1] - c.points[2]).cwiseAbs().maxCoeff());
  const Vec3 way = c.across * source.sign() * std::ceil(size * source.spread(1e-3, 2));
  if (!source.one_in(16)) {
    FourPoints& end = source.one_in(4) ? pair.x1 : pair.x0;
    for (int k = 0; k < (edges ? 2 : 1); ++k) end[k] += way;
  }
  const CcdResult found = (edges ? edge_edge_ccd : vertex_face_ccd)(pair.x0, pair.x1, settings);
  if (found.answer != Answer::Separated) return {};
  return fmt::format("a pair that comes as near as {:a} is called separated: {}", c.thickness,
                     describe(pair));
}

std::string ask_flat_pair(Source& source, Tally& tally) {
  auto [a, b] = make_flat_pair(source);
  if (source.one_in(2)) std::swap(a, b);
  std::rotate(a.begin(), a.begin() + source.pick(3), a.end());
  if (triangles_intersect(a, b) == triangles_meet(a, b, tally)) return {};
  std::string text = "triangles in one plane, exact arithmetic says otherwise than the library:";
  for (const auto& triangle : {a, b}) {
    for (const Vec3& p : triangle) text += fmt::format(" ({:a} {:a} {:a})", p.x(), p.y(), p.z());
  }
  return text;
}

}  // namespace

std::string ask_touching(Source& source, Tally& tally) {
  const auto all = targets();
  const testing::OneTarget only(all[source.pick(static_cast<unsigned>(all.size()))]);
  for (int k = 0; k < kContacts; ++k) {
    if (std::string wrong = ask_contact(source); !wrong.empty()) return wrong;
  }
  for (int k = 0; k < kFlatPairs; ++k) {
    if (std::string wrong = ask_flat_pair(source, tally); !wrong.empty()) return wrong;
  }
  tally.touching += kContacts + kFlatPairs;
  return {};
}

}  // namespace foldproof::adversary
