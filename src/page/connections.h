/// Serves many connections on a local port; no client can lock out others.
///
/// One thread polls all connections, so a slow or idle one costs a few kB and no thread. Worker threads
/// answer complete requests. Everything is bounded: the number of connections, their time, the size of
/// requests, and the bytes of answers that wait to be sent.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

#include "foldproof/base.h"

namespace foldproof {

/// What is sent back over a connection, and whether the connection is closed after it.
struct Reply {
  std::string bytes;
  bool close = true;
};

/// How requests are answered.
struct RequestHandler {
  /// Answers the head of a request, including its final empty line. Called from many threads; must not throw.
  std::function<Reply(std::string head)> answer;
  std::string too_long;  ///< The reply to a head larger than `kMaxHead`.
};

class Connections {
 public:
  /// Browsers open six per window. One more closes the connection that has waited longest.
  static constexpr std::size_t kMaxConnections = 128;
  /// Bytes of a head. Browsers send the cookies of all servers of this machine along.
  static constexpr std::size_t kMaxHead = std::size_t{1} << 14;
  /// How long a connection may be idle, or take to send a request.
  static constexpr std::chrono::seconds kHeadTime{5};
  /// How long a client may receive nothing of its answer.
  static constexpr std::chrono::seconds kStallTime{30};
  /// Bytes of answers that wait to be sent; beyond it the oldest are dropped, except that some answers are
  /// kept whatever their size, since a browser fetches as many at a time.
  static constexpr std::size_t kMaxUnsent = std::size_t{1} << 28, kMinUnsentAnswers = 16;

  Connections() = default;
  ~Connections();
  Connections(const Connections&) = delete;
  Connections& operator=(const Connections&) = delete;

  /// Listens on 127.0.0.1. Returns 0, or an errno. Call it again only after a failure.
  int listen(int port);

  /// Serves until `stop` is set. Then it returns within milliseconds, except that it finishes answers being
  /// computed. Sets `ended` when it accepts no more requests. Error: listening failed, no threads.
  Result<void> serve(const RequestHandler& handler, const std::atomic<bool>& stop, std::atomic<bool>& ended);

 private:
  int socket_ = -1;
};

}  // namespace foldproof
