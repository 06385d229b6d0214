/// Connections to this machine's port, many at a time, of which none can keep the others out.
///
/// One thread waits for all of them, so that a slow or idle one costs a few kB and no thread; what has come
/// whole is answered by others. Everything is bounded: their number, the time that each takes, the size of
/// what is asked, and the bytes that wait to be fetched.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

#include "foldproof/base.h"

namespace foldproof {

/// What goes back over a connection, and whether that was the last of it.
struct Reply {
  std::string bytes;
  bool last = true;
};

/// How requests are answered.
struct Answering {
  /// To the head of a request, up to and with its empty line. Many threads at a time; throws nothing.
  std::function<Reply(std::string head)> answer;
  std::string too_long;  ///< What goes back, whole, for a head beyond `kMostHead`.
};

class Connections {
 public:
  /// Browsers open six per window. Where there are more, the one that has waited longest makes room.
  static constexpr std::size_t kMost = 128;
  /// Bytes of a head. Browsers send along the cookies of all servers of this machine.
  static constexpr std::size_t kMostHead = std::size_t{1} << 14;
  /// How long a connection may idle, or take to say what it wants.
  static constexpr std::chrono::seconds kHeadTime{5};
  /// How long it may take nothing of what it asked for.
  static constexpr std::chrono::seconds kStallTime{30};
  /// Answers that wait to be fetched, in bytes; as with connections, the oldest makes room. A few are kept
  /// however large they are: a browser fetches as many at a time.
  static constexpr std::size_t kMostUnsent = std::size_t{1} << 28, kKept = 16;

  Connections() = default;
  ~Connections();
  Connections(const Connections&) = delete;
  Connections& operator=(const Connections&) = delete;

  /// Listens on 127.0.0.1. 0, or the errno of why it cannot. To be called until it can, and then no more.
  int listen(int port);

  /// Answers until `stop` is set, and returns within milliseconds, but for the answers that are being worked
  /// out. Sets `ended` when it takes no more. Error: the port can no longer be listened at, no threads.
  Result<void> serve(const Answering& answering, const std::atomic<bool>& stop, std::atomic<bool>& ended);

 private:
  int socket_ = -1;
};

}  // namespace foldproof
