/// A stand-in for what Foldproof uses of the library ipc-toolkit, which is not a Debian package. Written for
/// these tests from the names and signatures of its interfaces: all of IPC_STAND_IN that differs between
/// releases, as 13 for 1.3, is said here or where it is used. It finds candidates in no way of its own.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#ifndef IPC_STAND_IN
#define IPC_STAND_IN 16
#endif

namespace Eigen {
#if IPC_STAND_IN >= 14
template <class T>
using ConstRef = const Ref<const T>&;
#else  // what stands there is a reference to the matrix itself
template <class T>
using ConstRef = const T&;
#endif
}  // namespace Eigen

namespace ipc {

#if IPC_STAND_IN >= 14
using index_t = std::int32_t;
#else
using index_t = long;
#endif
using VectorMax3d = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 3, 1>;

#if IPC_STAND_IN >= 16
/// Which vertices may collide: all, or as a function says.
class CollisionFilter {
 public:
  CollisionFilter() = default;
  template <class F>
  CollisionFilter(F f) : can_collide_(std::move(f)) {}
  bool operator()(std::size_t i, std::size_t j) const { return !can_collide_ || can_collide_(i, j); }

 private:
  std::function<bool(std::size_t, std::size_t)> can_collide_;
};
#else
using CollisionFilter = std::function<bool(std::size_t, std::size_t)>;
#endif

}  // namespace ipc
