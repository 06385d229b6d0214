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

#include "base/try.h"

namespace foldproof {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kThreads = 8;
// Workers pause when so many bytes of answers wait to be collected.
constexpr std::size_t kMaxUncollected = Connections::kMaxUnsent / 4;
// How often `stop` is read: a signal handler cannot wake the loop.
constexpr int kPollMilliseconds = 20;
// After the last answer the client has this long to read it. Closing at once would discard it if the client
// is still sending.
constexpr auto kDrainTime = 1s;
// Connections accepted in one iteration, so that the open ones are served in between.
constexpr int kMaxAccepts = 32;

/// Threads that compute answers. The destructor waits for answers being computed and drops queued requests.
class Workers {
 public:
  struct Done {
    std::uint64_t id;
    Reply reply;
  };

  explicit Workers(const RequestHandler& handler) : handler_(handler) {}
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
    return fail(ErrorCode::LimitExceeded, "the page's server",
                "cannot start: " + std::generic_category().message(code),
                "end other programs, or raise the limits on threads and open files");
  }

  /// A descriptor that is readable when there are answers to collect.
  int done_event() const { return done_event_; }

  void submit(std::uint64_t id, std::string head) {
    {
      const std::lock_guard lock(mutex_);
      queue_.emplace_back(id, std::move(head));
    }
    wake_.notify_one();
  }

  std::vector<Done> collect() {
    std::uint64_t count = 0;
    [[maybe_unused]] const ssize_t read = ::read(done_event_, &count, sizeof count);
    std::vector<Done> done;
    {
      const std::lock_guard lock(mutex_);
      done = std::exchange(done_, {});
      uncollected_ = 0;
    }
    if (!done.empty()) wake_.notify_all();
    return done;
  }

 private:
  void work() {
    std::unique_lock lock(mutex_);
    for (;;) {
      wake_.wait(lock, [&] { return ending_ || (!queue_.empty() && uncollected_ < kMaxUncollected); });
      if (ending_) return;
      auto [id, head] = std::move(queue_.front());
      queue_.pop_front();
      lock.unlock();
      Reply reply = handler_.answer(std::move(head));
      lock.lock();
      uncollected_ += reply.bytes.size();
      done_.push_back({id, std::move(reply)});
      const std::uint64_t one = 1;
      [[maybe_unused]] const ssize_t written = ::write(done_event_, &one, sizeof one);
    }
  }

  const RequestHandler& handler_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::pair<std::uint64_t, std::string>> queue_;
  std::vector<Done> done_;
  std::vector<std::thread> threads_;
  std::size_t uncollected_ = 0;  // bytes in done_
  int done_event_ = -1;
  bool ending_ = false;
};

struct Connection {
  enum class State : std::uint8_t { Reading, Answering, Writing, Draining };
  int socket;
  State state = State::Reading;
  Clock::time_point entered = Clock::now();  ///< When the state was entered.
  Clock::time_point last_sent = entered;     ///< When the last bytes were sent.
  std::string in = {}, out = {};
  std::size_t sent = 0;
  bool close = false;  ///< After `out` is sent.

  void enter(State next) {
    state = next;
    entered = last_sent = Clock::now();
  }
  bool timed_out(Clock::time_point now) const {
    switch (state) {
      case State::Reading:
        return now - entered > Connections::kHeadTime;
      case State::Answering:
        return false;
      case State::Writing:
        return now - last_sent > Connections::kStallTime;
      case State::Draining:
        return now - entered > kDrainTime;
    }
    return true;
  }
};

/// The event loop of one call of `serve`.
class Loop {
 public:
  Loop(int socket, const RequestHandler& handler)
      : listening_(socket), handler_(handler), workers_(handler) {}
  ~Loop() {
    for (const auto& [id, c] : connections_) ::close(c.socket);
  }
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  Result<void> run(const std::atomic<bool>& stop) {
    FOLDPROOF_TRY(workers_.start());
    int code = 0;
    try {
      while (!stop && code == 0) code = iterate();
    } catch (const std::bad_alloc&) {
      code = ENOMEM;
    }
    if (code == 0) return {};
    return fail(ErrorCode::FileAccess, "the page's server",
                "can no longer listen: " + std::generic_category().message(code), "start it again");
  }

 private:
  using State = Connection::State;
  using Iterator = std::map<std::uint64_t, Connection>::iterator;

  /// Handles what has happened since the last iteration. Returns 0, or an errno if listening failed.
  int iterate() {
    polled_.clear();
    // poll ignores negative descriptors. A connection in state Answering is not polled: if the client has
    // closed it, poll would report that in every iteration.
    polled_.push_back({Clock::now() < accept_after_ ? -1 : listening_, POLLIN, 0});
    polled_.push_back({workers_.done_event(), POLLIN, 0});
    for (const auto& [id, c] : connections_) {
      const short events = c.state == State::Writing ? POLLOUT : POLLIN;
      polled_.push_back({c.state == State::Answering ? -1 : c.socket, events, 0});
    }
    if (::poll(polled_.data(), polled_.size(), kPollMilliseconds) < 0) {
      if (errno == EINTR) return 0;
      // The only other possible error is a lack of memory, which is temporary.
      std::this_thread::sleep_for(std::chrono::milliseconds(kPollMilliseconds));
      return 0;
    }
    const Clock::time_point now = Clock::now();
    std::size_t k = 2;
    for (Iterator it = connections_.begin(); it != connections_.end(); ++k) {
      const bool open = !it->second.timed_out(now) && (polled_[k].revents == 0 || transfer(it));
      it = open ? std::next(it) : drop(it);
    }
    for (Workers::Done& done : workers_.collect()) reply(std::move(done));
    for (const std::uint64_t id : std::exchange(too_long_, {})) reply({id, {handler_.too_long, true}});
    return polled_[0].revents == 0 ? 0 : accept();
  }

  Iterator drop(Iterator it) {
    ::close(it->second.socket);
    return connections_.erase(it);
  }

  /// The connection that has been in its state for longest, except for those in state Answering; end() if
  /// there is none.
  Iterator oldest(std::optional<State> state = {}) {
    Iterator found = connections_.end();
    for (Iterator it = connections_.begin(); it != connections_.end(); ++it) {
      const Connection& c = it->second;
      if (c.state == State::Answering || (state && c.state != *state)) continue;
      if (found == connections_.end() || c.entered < found->second.entered) found = it;
    }
    return found;
  }

  int accept() {
    for (int k = 0; k < kMaxAccepts; ++k) {
      if (connections_.size() >= Connections::kMaxConnections && !close_oldest()) return 0;
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
          close_oldest();
          return 0;
        default:
          return errno;
      }
    }
    return 0;
  }

  /// Closes the oldest connection. False if none can be closed; then nothing is accepted for a while.
  bool close_oldest() {
    const Iterator it = oldest();
    if (it != connections_.end()) {
      drop(it);
      return true;
    }
    accept_after_ = Clock::now() + 100ms;
    return false;
  }

  /// Reads or writes as much as possible without blocking; false if the connection is to be closed.
  bool transfer(Iterator it) {
    switch (it->second.state) {
      case State::Reading:
        return read(it);
      case State::Writing:
        return write(it);
      case State::Draining:
        return drain(it->second);
      case State::Answering:
        break;
    }
    return true;
  }

  static bool would_block(ssize_t count) {
    return count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR);
  }

  bool read(Iterator it) {
    Connection& c = it->second;
    const ssize_t count = ::recv(c.socket, buffer_.data(), buffer_.size(), 0);
    if (count <= 0) return would_block(count);
    c.in.append(buffer_.data(), static_cast<std::size_t>(count));
    submit_head(it);
    return true;
  }

  /// Submits the request if its head, which ends with an empty line, is complete.
  void submit_head(Iterator it) {
    Connection& c = it->second;
    constexpr std::string_view kEnd = "\n\r\n";
    const std::size_t end = c.in.find(kEnd);
    const bool complete = end != std::string::npos;
    if ((complete ? end : c.in.size()) > Connections::kMaxHead) {
      c.enter(State::Answering);
      too_long_.push_back(it->first);
    } else if (complete) {
      std::string head = c.in.substr(0, end + kEnd.size());
      c.in.erase(0, head.size());
      c.enter(State::Answering);
      workers_.submit(it->first, std::move(head));
    }
  }

  void reply(Workers::Done done) {
    const Iterator it = connections_.find(done.id);
    if (it == connections_.end()) return;
    Connection& c = it->second;
    c.out = std::move(done.reply.bytes);
    c.sent = 0;
    c.close = done.reply.close;
    c.enter(State::Writing);
    std::size_t count = 0, bytes = 0;
    for (const auto& [id, writing] : connections_) {
      count += writing.state == State::Writing;
      bytes += writing.out.size();
    }
    for (; count > Connections::kMinUnsentAnswers && bytes > Connections::kMaxUnsent; --count) {
      const Iterator victim = oldest(State::Writing);
      bytes -= victim->second.out.size();
      drop(victim);
    }
  }

  bool write(Iterator it) {
    Connection& c = it->second;
    const ssize_t count = ::send(c.socket, c.out.data() + c.sent, c.out.size() - c.sent, MSG_NOSIGNAL);
    if (count < 0) return would_block(count);
    c.last_sent = Clock::now();
    c.sent += static_cast<std::size_t>(count);
    if (c.sent < c.out.size()) return true;
    c.out = {};
    if (c.close) {
      c.in = {};
      ::shutdown(c.socket, SHUT_WR);
      c.enter(State::Draining);
      return true;
    }
    c.enter(State::Reading);
    submit_head(it);  // the next request may have been read already
    return true;
  }

  bool drain(const Connection& c) {
    const ssize_t count = ::recv(c.socket, buffer_.data(), buffer_.size(), 0);
    return count > 0 || would_block(count);
  }

  const int listening_;
  const RequestHandler& handler_;
  std::map<std::uint64_t, Connection> connections_;
  std::uint64_t next_id_ = 0;
  std::vector<std::uint64_t> too_long_;  // ids of connections to reply to with RequestHandler::too_long
  std::vector<::pollfd> polled_;
  std::vector<char> buffer_ = std::vector<char>(std::size_t{1} << 16);
  Clock::time_point accept_after_{};  // no connection is accepted before
  Workers workers_;
};

}  // namespace

Connections::~Connections() {
  if (socket_ >= 0) ::close(socket_);
}

int Connections::listen(int port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket < 0) return errno;
  // Makes a recently closed port available. Not SO_REUSEPORT, which would let two programs share one.
  const int yes = 1;
  ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  ::sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::bind(socket, reinterpret_cast<const ::sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(socket, static_cast<int>(kMaxConnections)) != 0) {
    const int code = errno;
    ::close(socket);
    return code;
  }
  socket_ = socket;
  return 0;
}

Result<void> Connections::serve(const RequestHandler& handler, const std::atomic<bool>& stop,
                                std::atomic<bool>& ended) {
  Loop loop(socket_, handler);
  auto done = loop.run(stop);
  ended = true;
  return done;
}

}  // namespace foldproof
