// The only file that uses MPI. No process blocks on another, which may have crashed: messages are polled,
// every process sends a heartbeat twice a second, and one that is silent for too long counts as lost.
#include "sweep_ranks.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <future>
#include <list>
#include <set>
#include <thread>

#include "base/try.h"
#include "commands.h"
#include "terminal.h"

#ifdef FOLDPROOF_MPI
#define OMPI_SKIP_MPICXX 1
#include <mpi.h>
#endif

namespace foldproof {
namespace {

/// A number that mpirun passes in the environment: Open MPI's variable, or that of other implementations.
/// `fallback` if neither is a number.
int from_environment(const char* open_mpi, const char* others, int fallback) {
  for (const char* name : {open_mpi, others}) {
    const char* text = std::getenv(name);
    if (text == nullptr) continue;
    const char* end = text + std::strlen(text);
    int number = 0;
    if (const auto read = std::from_chars(text, end, number); read.ec == std::errc() && read.ptr == end)
      return number;
  }
  return fallback;
}

int launched_count() { return from_environment("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", 1); }

}  // namespace

#ifndef FOLDPROOF_MPI

Result<Ranks> Ranks::join(double) {
  Ranks ranks;
  if (launched_count() < 2) return ranks;
  return fail(ErrorCode::InvalidArgument, "mpirun",
              fmt::format("started {} processes, but this program was built without MPI", launched_count()),
              "build it with -DFOLDPROOF_MPI=ON, or run it without mpirun");
}

Result<bool> Ranks::distribute(const SweepTask&) { return false; }
void Ranks::dismiss() {}
int Ranks::work(const std::function<Result<SweepSettings>()>&, const std::atomic<bool>&) {
  return kExitError;
}

#else

namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;
constexpr auto kHeartbeat = 500ms, kPause = 2ms;

/// From a worker: ready for its first motion; a line of results; the share done of a motion; an error after
/// which it cannot continue. To a worker: a motion; a heartbeat; exit, with '1' if all workers do.
enum Tag : int { kReady = 1, kLine, kShare, kCannotCheck, kMotion, kAlive, kExit };

double seconds_since(Clock::time_point then) {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

struct Message {
  int rank, tag;
  std::string text;
  MPI_Request request = MPI_REQUEST_NULL;
};

/// Sends and receives without blocking.
class Mailbox {
 public:
  void send(int rank, int tag, std::string text) {
    Message& m = out_.emplace_back(Message{rank, tag, std::move(text)});
    MPI_Isend(m.text.data(), static_cast<int>(m.text.size()), MPI_CHAR, rank, tag, MPI_COMM_WORLD,
              &m.request);
    // Tested later, in another call. NOLINTNEXTLINE(clang-analyzer-optin.mpi.MPI-Checker)
  }

  /// The messages received since the last call, in order of completion.
  std::vector<Message> receive() {
    int found = 0;
    do {
      MPI_Message message;
      MPI_Status status;
      if (MPI_Improbe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &found, &message, &status) != MPI_SUCCESS)
        break;
      if (!found) break;
      int size = 0;
      MPI_Get_count(&status, MPI_CHAR, &size);
      Message& m = in_.emplace_back(
          Message{status.MPI_SOURCE, status.MPI_TAG, std::string(static_cast<std::size_t>(size), '\0')});
      MPI_Imrecv(m.text.data(), size, MPI_CHAR, &message, &m.request);
    } while (found);
    std::vector<Message> complete;
    std::erase_if(in_, [&](Message& m) {
      if (!is_complete(m)) return false;
      complete.push_back(std::move(m));
      return true;
    });
    std::erase_if(out_, is_complete);
    return complete;
  }

  /// Whether everything has been sent, except to these ranks.
  bool sent(const std::set<int>& except) {
    std::erase_if(out_, is_complete);
    return std::all_of(out_.begin(), out_.end(), [&](const Message& m) { return except.contains(m.rank); });
  }

 private:
  static bool is_complete(Message& m) {
    int complete = 0;
    return MPI_Test(&m.request, &complete, MPI_STATUS_IGNORE) != MPI_SUCCESS || complete;
  }

  std::list<Message> out_, in_;  // MPI holds pointers into them
};

/// Lives as long as the program: a message to a lost rank never completes, and MPI keeps its address.
Mailbox& mailbox() {
  static Mailbox* const the_mailbox = new Mailbox;
  return *the_mailbox;
}

/// Serializes fields, separated by zero bytes, which no path contains.
std::string pack(std::size_t number, const SweepMotion& motion) {
  std::string text = fmt::format("{}", number);
  const auto add = [&](const std::string& field) { (text += '\0') += field; };
  add(fmt::format("{}", motion.bytes));
  add(fmt::format("{}", motion.modified));
  add(motion.status);
  add(motion.path);
  for (const std::string& file : motion.files) add(file);
  return text;
}

SweepMotion unpack(const std::string& text, std::size_t& number) {
  std::vector<std::string> fields;
  for (std::size_t at = 0, end = 0; end != text.npos; at = end + 1) {
    end = text.find('\0', at);
    fields.push_back(text.substr(at, end - at));
  }
  number = std::stoull(fields.at(0));
  return {.path = fields.at(4),
          .files = {fields.begin() + 5, fields.end()},
          .bytes = std::stoull(fields.at(1)),
          .modified = std::stoll(fields.at(2)),
          .status = fields.at(3)};
}

/// Rank 0.
class Leader {
 public:
  Leader(const SweepTask& task, int ranks, double timeout)
      : task_(task), queue_(task.motions, task.todo), timeout_(timeout) {
    for (int rank = 1; rank < ranks; ++rank) workers_[rank].heard = Clock::now();
  }

  Result<bool> run() {
    while (!queue_.finished()) {
      if (*task_.cancel) return false;
      for (const Message& message : mailbox().receive()) {
        FOLDPROOF_TRY(handle(message));
      }
      FOLDPROOF_TRY(find_lost());
      assign_motions();
      send_heartbeats();
      std::this_thread::sleep_for(kPause);
    }
    return true;
  }

  /// Ranks that count as lost.
  std::set<int> lost() const {
    std::set<int> lost;
    for (const auto& [rank, worker] : workers_) {
      if (worker.lost) lost.insert(rank);
    }
    return lost;
  }

 private:
  struct Worker {
    Clock::time_point heard;
    std::optional<std::size_t> motion = {};
    double share = 0;
    bool idle = false, lost = false, failed = false;

    bool works() const { return !lost && !failed; }
  };

  Result<void> handle(const Message& message) {
    Worker& worker = workers_.at(message.rank);
    worker.heard = Clock::now();
    worker.lost = false;
    switch (message.tag) {
      case kReady:
        worker.idle = true;
        return {};
      case kShare:
        worker.share = std::strtod(message.text.c_str(), nullptr);
        return {};
      case kCannotCheck:
        worker.failed = true;
        return worker_lost(message.rank, message.text);
      default:
        break;
    }
    const std::size_t line_end = message.text.find('\n');
    const std::size_t motion = std::stoull(message.text);
    worker.idle = true;
    worker.motion.reset();
    if (!queue_.finish(message.rank, motion)) return {};
    return task_.done(motion, message.text.substr(line_end + 1));
  }

  Result<void> worker_lost(int rank, const std::string& why) {
    Worker& worker = workers_.at(rank);
    worker.idle = false;
    worker.motion.reset();
    print_error({fmt::format("rank {}", rank), why, "the other ranks do its work"});
    const auto given_up = queue_.worker_lost(rank);
    if (!given_up) return {};
    const SweepMotion& motion = task_.motions[*given_up];
    return task_.done(*given_up,
                      failed_sweep_line(motion, task_.settings,
                                        {motion.path, "two processes were lost while they checked it",
                                         "check it alone, on a machine with more memory"}));
  }

  Result<void> find_lost() {
    for (auto& [rank, worker] : workers_) {
      if (worker.lost || seconds_since(worker.heard) < timeout_) continue;
      worker.lost = true;
      if (worker.failed) continue;
      FOLDPROOF_TRY(worker_lost(rank, fmt::format("has not responded for {:g} s", timeout_)));
    }
    if (std::all_of(workers_.begin(), workers_.end(), [](const auto& w) { return !w.second.works(); }))
      return fail(ErrorCode::FileAccess, "mpirun", "no rank is left that checks",
                  "the same command continues from here");
    return {};
  }

  void assign_motions() {
    for (auto& [rank, worker] : workers_) {
      if (!worker.idle || !worker.works()) continue;
      worker.motion = queue_.assign(rank);
      if (!worker.motion) return;
      worker.idle = false;
      worker.share = 0;
      mailbox().send(rank, kMotion, pack(*worker.motion, task_.motions[*worker.motion]));
    }
  }

  void send_heartbeats() {
    if (Clock::now() - last_heartbeat_ < kHeartbeat) return;
    last_heartbeat_ = Clock::now();
    std::vector<std::pair<std::size_t, double> > parts;
    for (const auto& [rank, worker] : workers_) {
      if (!worker.lost) mailbox().send(rank, kAlive, "");
      if (worker.motion) parts.emplace_back(*worker.motion, worker.share);
    }
    task_.progress(parts);
  }

  const SweepTask& task_;
  SweepQueue queue_;
  double timeout_;
  std::map<int, Worker> workers_;
  Clock::time_point last_heartbeat_ = {};
};

/// Any other rank. Motions are checked in another thread, so that heartbeats continue however long a step
/// takes.
class Worker {
 public:
  Worker(const std::function<Result<SweepSettings>()>& load, const std::atomic<bool>& interrupted,
         double timeout)
      : interrupted_(interrupted), timeout_(timeout), loading_(std::async(std::launch::async, load)) {}

  /// Runs until dismissed; true if all ranks exit together, nothing if rank 0 is lost.
  std::optional<bool> run() {
    std::optional<bool> together;
    while (!together && seconds_since(heard_) < timeout_) {
      for (const Message& message : mailbox().receive()) {
        heard_ = Clock::now();
        if (message.tag == kMotion) start(message.text);
        if (message.tag == kExit) together = message.text == "1";
      }
      poll_tasks();
      send_heartbeats();
      std::this_thread::sleep_for(kPause);
    }
    stop_ = true;
    return together;
  }

 private:
  template <class T>
  static bool is_ready(const std::future<T>& future) {
    return future.valid() && future.wait_for(0s) == std::future_status::ready;
  }

  void start(const std::string& text) {
    std::size_t number = 0;
    SweepMotion motion = unpack(text, number);
    share_ = 0;
    checking_ = std::async(std::launch::async, [this, number, motion = std::move(motion)] {
      CheckHooks hooks;
      hooks.cancel = &stop_;
      hooks.progress = [this](const CheckTotals& totals, std::uint64_t expected) {
        share_ = static_cast<double>(totals.steps) / static_cast<double>(expected);
      };
      const auto line = sweep_line(motion, *settings_, hooks);
      return line ? fmt::format("{}\n{}", number, *line) : std::string();
    });
  }

  void poll_tasks() {
    if (is_ready(loading_)) {
      auto loaded = loading_.get();
      if (loaded) settings_ = std::move(*loaded);
      mailbox().send(0, loaded ? kReady : kCannotCheck, loaded ? "" : loaded.error().line());
    }
    if (interrupted_ && !stop_.exchange(true)) mailbox().send(0, kCannotCheck, "was interrupted");
    if (!is_ready(checking_)) return;
    std::string line = checking_.get();
    if (!line.empty()) mailbox().send(0, kLine, std::move(line));
  }

  void send_heartbeats() {
    if (Clock::now() - last_heartbeat_ < kHeartbeat) return;
    last_heartbeat_ = Clock::now();
    mailbox().send(0, kShare, fmt::format("{}", share_.load()));
  }

  const std::atomic<bool>& interrupted_;
  double timeout_;
  Clock::time_point heard_ = Clock::now(), last_heartbeat_ = {};
  std::optional<SweepSettings> settings_;
  std::atomic<bool> stop_ = false;
  std::atomic<double> share_ = 0;
  // Last, so that they are destroyed first: their tasks use the other members.
  std::future<Result<SweepSettings> > loading_;
  std::future<std::string> checking_;
};

}  // namespace

Result<Ranks> Ranks::join(double timeout) {
  Ranks ranks;
  if (launched_count() < 2) return ranks;
  int threads = 0, known = 1;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &threads);
  MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
  MPI_Comm_size(MPI_COMM_WORLD, &known);
  if (known != launched_count()) {
    MPI_Finalize();
    return fail(ErrorCode::InvalidArgument, "mpirun",
                fmt::format("started {} processes, of which MPI knows {}", launched_count(), known),
                "use the mpirun of the MPI that this program was built with");
  }
  MPI_Comm_rank(MPI_COMM_WORLD, &ranks.rank_);
  ranks.count_ = known;
  ranks.local_count_ = std::max(1, from_environment("OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS", known));
  ranks.timeout_ = timeout;
  return ranks;
}

Result<bool> Ranks::distribute(const SweepTask& task) {
  Leader leader(task, count_, timeout_);
  auto done = leader.run();
  lost_ = leader.lost();
  return done;
}

void Ranks::dismiss() {
  if (alone()) return;
  for (int rank = 1; rank < count_; ++rank) mailbox().send(rank, kExit, lost_.empty() ? "1" : "0");
  if (lost_.empty()) {
    MPI_Finalize();
    return;
  }
  // MPI_Finalize would wait for lost ranks. Messages get a second to arrive.
  const auto start = Clock::now();
  while (seconds_since(start) < 1 && !mailbox().sent(lost_)) {
    mailbox().receive();
    std::this_thread::sleep_for(kPause);
  }
}

int Ranks::work(const std::function<Result<SweepSettings>()>& load, const std::atomic<bool>& interrupted) {
  const auto together = Worker(load, interrupted, timeout_).run();
  if (!together) {
    print_error({fmt::format("rank {}", rank_), "has lost rank 0", "the same command continues from here"});
    return kExitError;
  }
  if (*together) MPI_Finalize();
  return kExitClean;
}

#endif

}  // namespace foldproof
