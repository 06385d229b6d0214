#include "adversary/case.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "adversary/touching_pairs.h"
#include "foldproof/eigen.h"
#include "oracle/families.h"

namespace foldproof::adversary {

Vec3 random_vector(Source& source) {
  const double x = source.real(-1, 1), y = source.real(-1, 1), z = source.real(-1, 1);
  return {x, y, z};
}

namespace {

// Everything about a scene but its steps: poses are base + s * way + s^2 * bend, turned by s.
struct Motion {
  std::vector<std::vector<Vec3>> base, way, bend;
  std::vector<Vec3> turn;  // axis times angle; zero keeps integers what they are
  double shake = 0;        // of every coordinate, at every end
};

double size_of(const std::vector<std::vector<Vec3>>& objects) {
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const auto& object : objects) {
    for (const Vec3& p : object) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  return std::max((high - low).maxCoeff(), 1e-9);
}

class Builder {
 public:
  explicit Builder(Source& source) : source_(source) {}

  Case build() {
    case_.seed = source_.pick(65536);
    const bool touching = source_.one_in(5);
    if (touching) {
      take_touching_objects();
    } else {
      take_parts();
    }
    size_ = size_of(motion_.base);
    choose_motion();
    choose_settings();
    choose_scale();
    make_steps();
    return std::move(case_);
  }

 private:
  void add_object(const Mesh& mesh) {
    Object object;
    object.vertex_count = static_cast<Index>(mesh.vertices.size());
    object.triangles = mesh.triangles;
    object.leaf_triangles = source_.one_in(2) ? 12 : 1 + source_.pick(16);
    case_.objects.push_back(std::move(object));
    motion_.base.push_back(mesh.vertices);
  }

  void take_touching_objects() {
    const bool tiny = source_.one_in(8);
    const TouchingObjects touching =
        tiny ? make_tiny_touching_objects(source_) : make_touching_objects(source_);
    unit_ = tiny ? 0 : 1;
    exact_thickness_ = touching.thickness;
    if (source_.one_in(2)) press_ = touching.across;
    if (source_.one_in(3)) {
      Mesh both = touching.objects[0];
      both.add(touching.objects[1]);
      add_object(both);
    } else {
      add_object(touching.objects[0]);
      add_object(touching.objects[1]);
    }
  }

  // Each part stands near a point of those before, so that they cross, touch or pass by; or beside all of
  // them.
  void take_parts() {
    const int objects = source_.whole(1, 3), most = source_.one_in(8) ? 90 : 30;
    Mesh all;
    for (int k = 0; k < objects; ++k) {
      Mesh mesh;
      for (int parts = source_.whole(1, 2); parts > 0; --parts) {
        const double own = all.triangles.empty() ? 1 : std::min(ratio(source_), 30.0);
        Mesh part = source_.one_in(16) && !mesh.triangles.empty() ? mesh : make_part(source_, own);
        if (static_cast<int>(all.triangles.size() + part.triangles.size()) > most && !mesh.triangles.empty())
          break;
        const Vec3 shift = source_.one_in(3) ? all.random_point(source_) - part.random_point(source_) +
                                                   random_vector(source_) * own * source_.spread(1e-7, 3)
                                             : beside(all, part, own);
        for (Vec3& p : part.vertices) p += shift;
        mesh.add(part);
        all.add(part);
      }
      add_object(mesh);
    }
    if (source_.one_in(3)) snap();
  }

  // Boxes touch or leave a gap, along an axis; anywhere along the others.
  Vec3 beside(const Mesh& all, const Mesh& part, double size) {
    if (all.vertices.empty()) return Vec3::Zero();
    const int axis = source_.whole(0, 2);
    const auto reach = [axis](const Mesh& mesh, double side) {
      double most = -1e300;
      for (const Vec3& p : mesh.vertices) most = std::max(most, side * p[axis]);
      return most;
    };
    const double side = source_.sign(), gap = source_.one_in(6) ? 0 : size * source_.spread(1e-9, 1);
    Vec3 shift = all.random_point(source_) - part.random_point(source_);
    shift[axis] = side * (reach(all, side) + reach(part, -side) + gap);
    return shift;
  }

  // To a coarse grid: exact touching, equal coordinates, no area.
  void snap() {
    unit_ = std::ldexp(1, -source_.whole(2, 24));
    for (auto& object : motion_.base) {
      for (Vec3& p : object) p = oracle::nearest_multiple(p, unit_);
    }
  }

  Vec3 rounded(const Vec3& p) const { return unit_ == 0 ? p : oracle::nearest_multiple(p, unit_); }

  void choose_motion() {
    const bool stands = source_.one_in(8), bends = source_.one_in(3), each = source_.one_in(4);
    const double speed = size_ * source_.spread(1e-6, 2);
    const double curve = source_.one_in(2) ? 0 : speed * source_.spread(1e-6, 1);
    const bool turns = unit_ == 0 && source_.one_in(4);
    for (const auto& object : motion_.base) {
      const bool still = stands || source_.one_in(3);
      const Vec3 own = press_ == Vec3::Zero() ? Vec3(random_vector(source_) * speed)
                                              : Vec3(press_ * source_.sign() * std::ceil(speed));
      const Vec3 side = random_vector(source_) * curve;
      const Vec3 wave = random_vector(source_) / size_ * 3;
      auto& way = motion_.way.emplace_back(object.size(), Vec3::Zero());
      auto& bend = motion_.bend.emplace_back(object.size(), Vec3::Zero());
      motion_.turn.push_back(turns && !still ? Vec3(random_vector(source_) * source_.spread(1e-5, 1))
                                             : Vec3::Zero());
      if (still) continue;
      for (std::size_t v = 0; v < object.size(); ++v) {
        way[v] = rounded(each && source_.one_in(2) ? Vec3(random_vector(source_) * speed)
                         : bends                   ? Vec3(own * (1 + std::sin(wave.dot(object[v]))))
                                                   : own);
        bend[v] = rounded(side * std::sin(wave.dot(object[v])));
      }
    }
    if (source_.one_in(4)) motion_.shake = size_ * std::ldexp(1, -source_.whole(10, 52));
  }

  void choose_settings() {
    StepSettings& s = settings_;
    const unsigned how = source_.pick(16);
    if (how < 2) {
      s.thickness = size_ * source_.spread(1e-9, 1e-2);
    } else if (how < 3) {
      s.thickness = size_ * source_.spread(1e-2, 2);
    } else if (how < 4) {
      // How far apart two vertices stand along an axis.
      const int axis = source_.whole(0, 2);
      s.thickness = std::abs(random_vertex()[axis] - random_vertex()[axis]) * (source_.one_in(2) ? 1 : 1e-3);
    }
    if (exact_thickness_ >= 0) s.thickness = exact_thickness_;
    if (source_.one_in(3)) s.tolerance = size_ * source_.spread(1e-12, 1e-2);
    if (source_.one_in(8)) (source_.one_in(2) ? s.within : s.between) = false;
    s.within |= motion_.base.size() == 1;
  }
  Vec3 random_vertex() {
    const auto& object = motion_.base[source_.pick(static_cast<unsigned>(motion_.base.size()))];
    return object[source_.pick(static_cast<unsigned>(object.size()))];
  }

  // By a power of two; then so far off that few digits are left.
  void choose_scale() {
    exponent_ = source_.one_in(4) ? source_.whole(-990, 990) : source_.whole(-8, 8);
    // What moves on and stands far off must not leave the doubles.
    exponent_ = std::min(exponent_, 1000 - 60 - std::max(0, std::ilogb(size_)));
    // Affine maps leave what touches touching: without a thickness each axis may have a scale of its own.
    const bool stretched = settings_.thickness == 0 && source_.one_in(10);
    const bool far = !stretched && source_.one_in(3);
    // Or all is in one plane, as far off as doubles go.
    if (stretched && source_.one_in(3)) {
      plane_axis_ = source_.whole(0, 2);
      plane_ = std::ldexp(source_.sign(), source_.whole(-990, 990));
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (stretched && source_.one_in(2)) stretch_[axis] = source_.whole(-600, 0);
      const bool here = far && source_.one_in(2);
      const int least = source_.one_in(2) ? 36 : 0;
      offset_[axis] = here ? source_.sign() * std::ldexp(size_, source_.whole(least, 46)) : 0;
      if (here && unit_ != 0) offset_[axis] = std::ldexp(source_.sign(), std::ilogb(offset_[axis]));
    }
  }

  Poses pose_at(double s) {
    Poses poses;
    for (std::size_t k = 0; k < motion_.base.size(); ++k) {
      Pose& pose = poses.emplace_back();
      const Vec3 turn = s * motion_.turn[k], middle = motion_.base[k].front();
      const double angle = turn.norm();
      const Eigen::Matrix3d matrix =
          Eigen::AngleAxisd(angle, to_eigen(angle > 0 ? turn / angle : Vec3(0, 0, 1))).toRotationMatrix();
      for (std::size_t v = 0; v < motion_.base[k].size(); ++v) {
        Vec3 p = motion_.base[k][v];
        if (angle > 0) p = middle + to_vec3(matrix * to_eigen(p - middle));
        p += s * motion_.way[k][v] + s * s * motion_.bend[k][v];
        if (motion_.shake > 0) p += motion_.shake * random_vector(source_);
        for (int axis = 0; axis < 3; ++axis) {
          const double x = std::ldexp(p[axis] + offset_[axis], exponent_ + stretch_[axis]);
          pose.push_back(axis == plane_axis_ ? plane_ : x);
        }
      }
    }
    return poses;
  }

  void make_steps() {
    settings_.thickness = std::ldexp(settings_.thickness, exponent_);
    settings_.tolerance = std::ldexp(settings_.tolerance, exponent_);
    const int count = source_.one_in(3) ? source_.whole(4, 14) : source_.whole(1, 3);
    double stride = source_.one_in(2) ? 1 : std::ldexp(1, -source_.whole(1, 4));
    double s = -stride * source_.whole(0, count) + (source_.one_in(2) ? 0 : stride / 2);
    if (source_.one_in(4)) s += stride * source_.real(-1, 1);
    Poses at = pose_at(s);
    for (int k = 0; k < count; ++k) {
      const unsigned how = source_.pick(24);
      const double next = how == 0   ? s - stride
                          : how == 1 ? s + 2 * stride
                          : how == 2 ? s
                          : how == 3 ? -s
                                     : s + stride;
      Poses to = pose_at(next);
      Step step{how == 4 ? pose_at(s) : at, to, settings_, checks()};
      if (source_.one_in(8)) step.settings.earliest_only = true;
      if (source_.one_in(12)) step.settings.thickness *= source_.one_in(2) ? 0 : 2;
      case_.steps.push_back(std::move(step));
      if (how != 5) {
        at = std::move(to);
        s = next;
      }
    }
  }

  unsigned checks() {
    unsigned bits = 0;
    constexpr std::array<std::pair<unsigned, unsigned>, 8> kOften = {{{kTargets, 3},
                                                                      {kOrder, 6},
                                                                      {kThreads, 24},
                                                                      {kLeaves, 4},
                                                                      {kPose, 3},
                                                                      {kSolver, 3},
                                                                      {kFailure, 24},
                                                                      {kSearches, 4}}};
    for (const auto& [bit, in] : kOften) bits |= source_.one_in(in) ? bit : 0;
    return bits;
  }

  Source& source_;
  Case case_;
  Motion motion_;
  StepSettings settings_;
  double size_ = 1, unit_ = 0, exact_thickness_ = -1;
  Vec3 press_ = Vec3::Zero();  // straight onto each other along this, unless zero
  Vec3 offset_ = Vec3::Zero();
  int exponent_ = 0;
  std::array<int, 3> stretch_{};
  int plane_axis_ = -1;
  double plane_ = 0;
};

}  // namespace

Case make_case(Source& source) { return Builder(source).build(); }

std::string describe(const Case& c) {
  std::string text;
  for (std::size_t k = 0; k < c.objects.size(); ++k) {
    text += fmt::format("object {}: {} vertices, leaves of {} triangles, triangles", k,
                        c.objects[k].vertex_count, c.objects[k].leaf_triangles);
    for (const Triangle& t : c.objects[k].triangles) text += fmt::format(" {{{},{},{}}}", t[0], t[1], t[2]);
    text += "\n";
  }
  for (std::size_t i = 0; i < c.steps.size(); ++i) {
    const Step& step = c.steps[i];
    text += fmt::format(
        "step {}: thickness {:a}, tolerance {:a}, within {}, between {}, earliest_only {}, checks {}\n", i,
        step.settings.thickness, step.settings.tolerance, step.settings.within, step.settings.between,
        step.settings.earliest_only, step.checks);
    for (std::size_t k = 0; k < c.objects.size(); ++k) {
      for (std::size_t v = 0; v < step.x0[k].size(); v += 3) {
        const double *p = &step.x0[k][v], *q = &step.x1[k][v];
        text += fmt::format("  object {} vertex {}: {:a} {:a} {:a} -> {:a} {:a} {:a}\n", k, v / 3, p[0], p[1],
                            p[2], q[0], q[1], q[2]);
      }
    }
  }
  return text;
}

}  // namespace foldproof::adversary
