#include "page/connections.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <vector>

namespace foldproof {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kThreads = 8;
// Bytes of answers that the threads may be ahead.
constexpr std::size_t kAhead = Connections::kMostUnsent / 4;
// How often it looks whether it is to stop: a signal handler cannot wake it.
constexpr int kLookMilliseconds = 20;
// After the last answer the other side has this long to read it; closing at once would take it away from one
// that is still sending.
constexpr auto kDrainTime = 1s;
// Taken in one go, so that those that are there already are served in between.
constexpr int kMostAtOnce = 32;

/// Threads that work out answers. Ending it waits for those that are being worked out, and drops the others.
class Workers {
 public:
  struct Done {
    std::uint64_t id;
    Reply reply;
  };

  explicit Workers(const Answering& answering) : answering_(answering) {}
  ~Workers() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
    if (done_event_ >= 0) ::close(done_event_);
  }
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  Result<void> start() {
    done_event_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    int code = done_event_ < 0 ? errno : 0;
    try {
      while (code == 0 && threads_.size() < kThreads) threads_.emplace_back([this] { work(); });
    } catch (const std::system_error& error) {
      code = error.code().value();
    }
    if (code == 0) return {};
    return fail("the page's server", "cannot start: " + std::generic_category().message(code),
                "end other programs, or raise the limits on threads and open files");
  }

  /// Becomes readable when there is something to take.
  int done_event() const { return done_event_; }

  void ask(std::uint64_t id, std::string head) {
    {
      const std::lock_guard lock(mutex_);
      asked_.emplace_back(id, std::move(head));
    }
    wake_.notify_one();
  }

  std::vector<Done> take() {
    std::uint64_t count = 0;
    [[maybe_unused]] const ssize_t read = ::read(done_event_, &count, sizeof count);
    std::vector<Done> done;
    {
      const std::lock_guard lock(mutex_);
      done = std::exchange(done_, {});
      ahead_ = 0;
    }
    if (!done.empty()) wake_.notify_all();
    return done;
  }

 private:
  void work() {
    std::unique_lock lock(mutex_);
    for (;;) {
      wake_.wait(lock, [&] { return ending_ || (!asked_.empty() && ahead_ < kAhead); });
      if (ending_) return;
      auto [id, head] = std::move(asked_.front());
      asked_.pop_front();
      lock.unlock();
      Reply reply = answering_.answer(std::move(head));
      lock.lock();
      ahead_ += reply.bytes.size();
      done_.push_back({id, std::move(reply)});
      const std::uint64_t one = 1;
      [[maybe_unused]] const ssize_t written = ::write(done_event_, &one, sizeof one);
    }
  }

  const Answering& answering_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::pair<std::uint64_t, std::string>> asked_;
  std::vector<Done> done_;
  std::vector<std::thread> threads_;
  std::size_t ahead_ = 0;  // bytes in done_
  int done_event_ = -1;
  bool ending_ = false;
};

struct Connection {
  enum class State : std::uint8_t { Reading, Answering, Writing, Draining };
  int socket;
  State state = State::Reading;
  Clock::time_point since = Clock::now();  ///< In this state.
  Clock::time_point moved = since;         ///< When the last byte went.
  std::string in = {}, out = {};
  std::size_t sent = 0;
  bool last = false;

  void enter(State next) {
    state = next;
    since = moved = Clock::now();
  }
  bool late(Clock::time_point now) const {
    switch (state) {
      case State::Reading:
        return now - since > Connections::kHeadTime;
      case State::Answering:
        return false;
      case State::Writing:
        return now - moved > Connections::kStallTime;
      case State::Draining:
        return now - since > kDrainTime;
    }
    return true;
  }
};

/// One `serve`.
class Loop {
 public:
  Loop(int socket, const Answering& answering)
      : listening_(socket), answering_(answering), workers_(answering) {}
  ~Loop() {
    for (const auto& [id, c] : connections_) ::close(c.socket);
  }
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  Result<void> run(const std::atomic<bool>& stop) {
    if (auto started = workers_.start(); !started) return started;
    int code = 0;
    try {
      while (!stop && code == 0) code = turn();
    } catch (const std::bad_alloc&) {
      code = ENOMEM;
    }
    if (code == 0) return {};
    return fail("the page's server", "can no longer listen: " + std::generic_category().message(code),
                "start it again");
  }

 private:
  using State = Connection::State;
  using At = std::map<std::uint64_t, Connection>::iterator;

  /// What has happened since the last one. 0, or an errno after which nothing more will come.
  int turn() {
    polled_.clear();
    // A negative one is passed over. Who is being answered is not looked at, as its end would be told again
    // and again.
    polled_.push_back({Clock::now() < rest_until_ ? -1 : listening_, POLLIN, 0});
    polled_.push_back({workers_.done_event(), POLLIN, 0});
    for (const auto& [id, c] : connections_) {
      const short events = c.state == State::Writing ? POLLOUT : POLLIN;
      polled_.push_back({c.state == State::Answering ? -1 : c.socket, events, 0});
    }
    if (::poll(polled_.data(), polled_.size(), kLookMilliseconds) < 0) {
      if (errno == EINTR) return 0;
      // Memory comes back; and there is nothing else that could be wrong.
      std::this_thread::sleep_for(std::chrono::milliseconds(kLookMilliseconds));
      return 0;
    }
    const Clock::time_point now = Clock::now();
    std::size_t k = 2;
    for (At at = connections_.begin(); at != connections_.end(); ++k) {
      const bool stays = !at->second.late(now) && (polled_[k].revents == 0 || move(at));
      at = stays ? std::next(at) : drop(at);
    }
    for (Workers::Done& done : workers_.take()) reply(std::move(done));
    for (const std::uint64_t id : std::exchange(too_long_, {})) reply({id, {answering_.too_long, true}});
    return polled_[0].revents == 0 ? 0 : accept();
  }

  At drop(At at) {
    ::close(at->second.socket);
    return connections_.erase(at);
  }

  /// The one that has been in its state for longest, answers apart. None where all are being answered.
  At oldest(std::optional<State> state = {}) {
    At found = connections_.end();
    for (At at = connections_.begin(); at != connections_.end(); ++at) {
      const Connection& c = at->second;
      if (c.state == State::Answering || (state && c.state != *state)) continue;
      if (found == connections_.end() || c.since < found->second.since) found = at;
    }
    return found;
  }

  int accept() {
    for (int k = 0; k < kMostAtOnce; ++k) {
      if (connections_.size() >= Connections::kMost && !make_room()) return 0;
      const int socket = ::accept4(listening_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
      if (socket >= 0) {
        const int yes = 1;
        ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
        connections_.emplace(next_id_++, Connection{.socket = socket});
        continue;
      }
      switch (errno) {
        case EINTR:
        case ECONNABORTED:
          continue;
        case EAGAIN:
          return 0;
        case EMFILE:
        case ENFILE:
        case ENOBUFS:
        case ENOMEM:
          make_room();
          return 0;
        default:
          return errno;
      }
    }
    return 0;
  }

  bool make_room() {
    const At at = oldest();
    if (at != connections_.end()) {
      drop(at);
      return true;
    }
    rest_until_ = Clock::now() + 100ms;
    return false;
  }

  /// Reads or writes as far as it goes without waiting; whether the connection stays.
  bool move(At at) {
    switch (at->second.state) {
      case State::Reading:
        return read(at);
      case State::Writing:
        return write(at);
      case State::Draining:
        return drain(at->second);
      case State::Answering:
        break;
    }
    return true;
  }

  static bool would_wait(ssize_t count) {
    return count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR);
  }

  bool read(At at) {
    Connection& c = at->second;
    const ssize_t count = ::recv(c.socket, buffer_.data(), buffer_.size(), 0);
    if (count <= 0) return would_wait(count);
    c.in.append(buffer_.data(), static_cast<std::size_t>(count));
    take_head(at);
    return true;
  }

  /// A head ends with an empty line.
  void take_head(At at) {
    Connection& c = at->second;
    constexpr std::string_view kEnd = "\n\r\n";
    const std::size_t end = c.in.find(kEnd);
    const bool whole = end != std::string::npos;
    if ((whole ? end : c.in.size()) > Connections::kMostHead) {
      c.enter(State::Answering);
      too_long_.push_back(at->first);
    } else if (whole) {
      std::string head = c.in.substr(0, end + kEnd.size());
      c.in.erase(0, head.size());
      c.enter(State::Answering);
      workers_.ask(at->first, std::move(head));
    }
  }

  void reply(Workers::Done done) {
    const At at = connections_.find(done.id);
    if (at == connections_.end()) return;
    Connection& c = at->second;
    c.out = std::move(done.reply.bytes);
    c.sent = 0;
    c.last = done.reply.last;
    c.enter(State::Writing);
    std::size_t count = 0, bytes = 0;
    for (const auto& [id, writing] : connections_) {
      count += writing.state == State::Writing;
      bytes += writing.out.size();
    }
    for (; count > Connections::kKept && bytes > Connections::kMostUnsent; --count) {
      const At victim = oldest(State::Writing);
      bytes -= victim->second.out.size();
      drop(victim);
    }
  }

  bool write(At at) {
    Connection& c = at->second;
    const ssize_t count = ::send(c.socket, c.out.data() + c.sent, c.out.size() - c.sent, MSG_NOSIGNAL);
    if (count < 0) return would_wait(count);
    c.moved = Clock::now();
    c.sent += static_cast<std::size_t>(count);
    if (c.sent < c.out.size()) return true;
    c.out = {};
    if (c.last) {
      c.in = {};
      ::shutdown(c.socket, SHUT_WR);
      c.enter(State::Draining);
      return true;
    }
    c.enter(State::Reading);
    take_head(at);  // the next one may have come with it
    return true;
  }

  bool drain(const Connection& c) {
    const ssize_t count = ::recv(c.socket, buffer_.data(), buffer_.size(), 0);
    return count > 0 || would_wait(count);
  }

  const int listening_;
  const Answering& answering_;
  std::map<std::uint64_t, Connection> connections_;
  std::uint64_t next_id_ = 0;
  std::vector<std::uint64_t> too_long_;  // to be told so
  std::vector<::pollfd> polled_;
  std::vector<char> buffer_ = std::vector<char>(std::size_t{1} << 16);
  Clock::time_point rest_until_{};  // it takes nobody before
  Workers workers_;
};

}  // namespace

Connections::~Connections() {
  if (socket_ >= 0) ::close(socket_);
}

int Connections::listen(int port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket < 0) return errno;
  // A port that was left a moment ago is free. Not SO_REUSEPORT: it would let two programs share one.
  const int yes = 1;
  ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  ::sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::bind(socket, reinterpret_cast<const ::sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(socket, static_cast<int>(kMost)) != 0) {
    const int code = errno;
    ::close(socket);
    return code;
  }
  socket_ = socket;
  return 0;
}

Result<void> Connections::serve(const Answering& answering, const std::atomic<bool>& stop,
                                std::atomic<bool>& ended) {
  Loop loop(socket_, answering);
  auto done = loop.run(stop);
  ended = true;
  return done;
}

}  // namespace foldproof
