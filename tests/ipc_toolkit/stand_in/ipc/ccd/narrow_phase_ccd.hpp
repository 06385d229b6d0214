#pragma once

#include "ipc/eigen.hpp"

namespace ipc {

class NarrowPhaseCCD {
 public:
  using Point = Eigen::ConstRef<VectorMax3d>;
  using Point3 = Eigen::ConstRef<Eigen::Vector3d>;

  virtual ~NarrowPhaseCCD() = default;
  virtual bool point_point_ccd(Point p0_t0, Point p1_t0, Point p0_t1, Point p1_t1, double& toi,
                               double min_distance = 0, double tmax = 1) const = 0;
  virtual bool point_edge_ccd(Point p_t0, Point e0_t0, Point e1_t0, Point p_t1, Point e0_t1, Point e1_t1,
                              double& toi, double min_distance = 0, double tmax = 1) const = 0;
  virtual bool point_triangle_ccd(Point3 p_t0, Point3 t0_t0, Point3 t1_t0, Point3 t2_t0, Point3 p_t1,
                                  Point3 t0_t1, Point3 t1_t1, Point3 t2_t1, double& toi,
                                  double min_distance = 0, double tmax = 1) const = 0;
  virtual bool edge_edge_ccd(Point3 ea0_t0, Point3 ea1_t0, Point3 eb0_t0, Point3 eb1_t0, Point3 ea0_t1,
                             Point3 ea1_t1, Point3 eb0_t1, Point3 eb1_t1, double& toi,
                             double min_distance = 0, double tmax = 1) const = 0;

#if IPC_STAND_IN >= 16
  double conservative_rescaling;  // which derived classes set
#endif
};

}  // namespace ipc
