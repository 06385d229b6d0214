// The only file that knows of MPI. Nobody waits for a single other one here, who may be gone: messages are
// looked for, never waited for, everybody gives a sign of life twice a second, and silence means that the
// other is lost.
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

#include "commands.h"
#include "terminal.h"

#ifdef FOLDPROOF_MPI
#define OMPI_SKIP_MPICXX 1
#include <mpi.h>
#endif

namespace foldproof {
namespace {

/// A number that mpirun tells its processes: Open MPI's, or that of the others. What is no number was told by
/// nobody.
int told(const char* open_mpi, const char* others, int otherwise) {
  for (const char* name : {open_mpi, others}) {
    const char* text = std::getenv(name);
    if (text == nullptr) continue;
    const char* end = text + std::strlen(text);
    int number = 0;
    if (const auto read = std::from_chars(text, end, number); read.ec == std::errc() && read.ptr == end)
      return number;
  }
  return otherwise;
}

int told_count() { return told("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", 1); }
int told_rank() { return told("OMPI_COMM_WORLD_RANK", "PMI_RANK", 0); }

}  // namespace

#ifndef FOLDPROOF_MPI

Result<Ranks> Ranks::join(double) {
  Ranks ranks;
  if (told_count() < 2) return ranks;
  if (told_rank() == 0) {
    return fail("mpirun",
                fmt::format("started {} processes, but this program was built without MPI", told_count()),
                "build it with -DFOLDPROOF_MPI=ON, or run it without mpirun");
  }
  ranks.superfluous_ = true;
  return ranks;
}

Result<bool> Ranks::hand_out(const SweepTask&) { return false; }
void Ranks::dismiss() {}
int Ranks::work(const std::function<Result<SweepSettings>()>&, const std::atomic<bool>&) {
  return kExitError;
}

#else

namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;
constexpr auto kBeat = 500ms, kPause = 2ms;

/// From a worker: it is ready for its first motion; the line of one; how far it is; it cannot go on, and why.
/// To a worker: a motion; rank 0 is still there; go home, with '1' when all others do.
enum Tag : int { kReady = 1, kLine, kShare, kUnfit, kMotion, kAlive, kHome };

double seconds_since(Clock::time_point then) {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

struct Message {
  int rank, tag;
  std::string text;
  MPI_Request request = MPI_REQUEST_NULL;
};

/// Sends and receives without waiting for anybody.
class Post {
 public:
  void send(int rank, int tag, std::string text) {
    Message& m = out_.emplace_back(Message{rank, tag, std::move(text)});
    MPI_Isend(m.text.data(), static_cast<int>(m.text.size()), MPI_CHAR, rank, tag, MPI_COMM_WORLD,
              &m.request);
    // Tested later, in another call. NOLINTNEXTLINE(clang-analyzer-optin.mpi.MPI-Checker)
  }

  /// What has come, in the order in which it was complete.
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
      if (!is_over(m)) return false;
      complete.push_back(std::move(m));
      return true;
    });
    std::erase_if(out_, is_over);
    return complete;
  }

  /// Whether all that was sent, except to these ranks, is on its way.
  bool sent(const std::set<int>& except) {
    std::erase_if(out_, is_over);
    return std::all_of(out_.begin(), out_.end(), [&](const Message& m) { return except.contains(m.rank); });
  }

 private:
  static bool is_over(Message& m) {
    int over = 0;
    return MPI_Test(&m.request, &over, MPI_STATUS_IGNORE) != MPI_SUCCESS || over;
  }

  std::list<Message> out_, in_;  // MPI holds pointers into them
};

/// Lives as long as the program: a message to a lost rank is never over, and MPI keeps its address.
Post& post() {
  static Post* const post = new Post;
  return *post;
}

/// Fields with a zero byte between them, which no path has.
std::string pack(std::size_t number, const SweepMotion& motion) {
  std::string text = fmt::format("{}", number);
  const auto add = [&](const std::string& field) { (text += '\0') += field; };
  add(fmt::format("{}", motion.bytes));
  add(fmt::format("{}", motion.modified));
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
  return {
      fields.at(3), {fields.begin() + 4, fields.end()}, std::stoull(fields.at(1)), std::stoll(fields.at(2))};
}

/// Rank 0.
class Leader {
 public:
  Leader(const SweepTask& task, int ranks, double patience)
      : task_(task), queue_(task.motions, task.todo), patience_(patience) {
    for (int rank = 1; rank < ranks; ++rank) workers_[rank].heard = Clock::now();
  }

  Result<bool> run() {
    while (!queue_.finished()) {
      if (*task_.cancel) return false;
      for (const Message& message : post().receive()) {
        if (auto done = take(message); !done) return tl::unexpected(done.error());
      }
      if (auto done = find_lost(); !done) return tl::unexpected(done.error());
      give();
      beat();
      std::this_thread::sleep_for(kPause);
    }
    return true;
  }

  /// Those that fell silent and never came back.
  std::set<int> lost() const {
    std::set<int> lost;
    for (const auto& [rank, worker] : workers_) {
      if (worker.silent) lost.insert(rank);
    }
    return lost;
  }

 private:
  struct Worker {
    Clock::time_point heard;
    std::optional<std::size_t> motion = {};
    double share = 0;
    bool idle = false, silent = false, unfit = false;

    bool works() const { return !silent && !unfit; }
  };

  Result<void> take(const Message& message) {
    Worker& worker = workers_.at(message.rank);
    worker.heard = Clock::now();
    worker.silent = false;
    switch (message.tag) {
      case kReady:
        worker.idle = true;
        return {};
      case kShare:
        worker.share = std::strtod(message.text.c_str(), nullptr);
        return {};
      case kUnfit:
        worker.unfit = true;
        return lose(message.rank, message.text);
      default:
        break;
    }
    const std::size_t begin = message.text.find('\n');
    const std::size_t motion = std::stoull(message.text);
    worker.idle = true;
    worker.motion.reset();
    if (!queue_.finish(message.rank, motion)) return {};
    return task_.done(motion, message.text.substr(begin + 1));
  }

  Result<void> lose(int rank, const std::string& why) {
    Worker& worker = workers_.at(rank);
    worker.idle = false;
    worker.motion.reset();
    print_error({fmt::format("rank {}", rank), why, "the other ranks do its work"});
    const auto given_up = queue_.lose(rank);
    if (!given_up) return {};
    const SweepMotion& motion = task_.motions[*given_up];
    return task_.done(*given_up,
                      failed_sweep_line(motion, task_.settings,
                                        {motion.path, "two processes were lost while they checked it",
                                         "check it alone, on a machine with more memory"}));
  }

  Result<void> find_lost() {
    for (auto& [rank, worker] : workers_) {
      if (worker.silent || seconds_since(worker.heard) < patience_) continue;
      worker.silent = true;
      if (worker.unfit) continue;
      auto done = lose(rank, fmt::format("has not been heard of for {:g} s", patience_));
      if (!done) return done;
    }
    if (std::all_of(workers_.begin(), workers_.end(), [](const auto& w) { return !w.second.works(); }))
      return fail("mpirun", "no rank is left that checks", "the same command goes on from here");
    return {};
  }

  void give() {
    for (auto& [rank, worker] : workers_) {
      if (!worker.idle || !worker.works()) continue;
      worker.motion = queue_.take(rank);
      if (!worker.motion) return;
      worker.idle = false;
      worker.share = 0;
      post().send(rank, kMotion, pack(*worker.motion, task_.motions[*worker.motion]));
    }
  }

  void beat() {
    if (Clock::now() - beat_ < kBeat) return;
    beat_ = Clock::now();
    std::vector<std::pair<std::size_t, double> > parts;
    for (const auto& [rank, worker] : workers_) {
      if (!worker.silent) post().send(rank, kAlive, "");
      if (worker.motion) parts.emplace_back(*worker.motion, worker.share);
    }
    task_.progress(parts);
  }

  const SweepTask& task_;
  SweepQueue queue_;
  double patience_;
  std::map<int, Worker> workers_;
  Clock::time_point beat_ = {};
};

/// Any other rank. A thread of its own checks, so that signs of life come however long a step takes.
class Worker {
 public:
  Worker(const std::function<Result<SweepSettings>()>& load, const std::atomic<bool>& interrupted,
         double patience)
      : interrupted_(interrupted), patience_(patience), loading_(std::async(std::launch::async, load)) {}

  /// Whether all go home together; nothing when rank 0 is lost.
  std::optional<bool> run() {
    std::optional<bool> together;
    while (!together && seconds_since(heard_) < patience_) {
      for (const Message& message : post().receive()) {
        heard_ = Clock::now();
        if (message.tag == kMotion) start(message.text);
        if (message.tag == kHome) together = message.text == "1";
      }
      look();
      beat();
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

  void look() {
    if (is_ready(loading_)) {
      auto loaded = loading_.get();
      if (loaded) settings_ = std::move(*loaded);
      post().send(0, loaded ? kReady : kUnfit, loaded ? "" : loaded.error().line());
    }
    if (interrupted_ && !stop_.exchange(true)) post().send(0, kUnfit, "was told to end");
    if (!is_ready(checking_)) return;
    std::string line = checking_.get();
    if (!line.empty()) post().send(0, kLine, std::move(line));
  }

  void beat() {
    if (Clock::now() - beat_ < kBeat) return;
    beat_ = Clock::now();
    post().send(0, kShare, fmt::format("{}", share_.load()));
  }

  const std::atomic<bool>& interrupted_;
  double patience_;
  Clock::time_point heard_ = Clock::now(), beat_ = {};
  std::optional<SweepSettings> settings_;
  std::atomic<bool> stop_ = false;
  std::atomic<double> share_ = 0;
  // The last to be made and the first to go: what runs in them uses the rest.
  std::future<Result<SweepSettings> > loading_;
  std::future<std::string> checking_;
};

}  // namespace

Result<Ranks> Ranks::join(double patience) {
  Ranks ranks;
  if (told_count() < 2) return ranks;
  int threads = 0, known = 1;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &threads);
  MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
  MPI_Comm_size(MPI_COMM_WORLD, &known);
  if (known != told_count()) {
    ranks.superfluous_ = told_rank() != 0;
    MPI_Finalize();
    if (ranks.superfluous_) return ranks;
    return fail("mpirun", fmt::format("started {} processes, of which MPI knows {}", told_count(), known),
                "use the mpirun of the MPI that this program was built with");
  }
  MPI_Comm_rank(MPI_COMM_WORLD, &ranks.rank_);
  ranks.count_ = known;
  ranks.here_ = std::max(1, told("OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS", known));
  ranks.patience_ = patience;
  return ranks;
}

Result<bool> Ranks::hand_out(const SweepTask& task) {
  Leader leader(task, count_, patience_);
  auto done = leader.run();
  lost_ = leader.lost();
  return done;
}

void Ranks::dismiss() {
  if (alone()) return;
  for (int rank = 1; rank < count_; ++rank) post().send(rank, kHome, lost_.empty() ? "1" : "0");
  if (lost_.empty()) {
    MPI_Finalize();
    return;
  }
  // MPI_Finalize would wait for who is lost. What was sent gets a second to arrive.
  const auto start = Clock::now();
  while (seconds_since(start) < 1 && !post().sent(lost_)) {
    post().receive();
    std::this_thread::sleep_for(kPause);
  }
}

int Ranks::work(const std::function<Result<SweepSettings>()>& load, const std::atomic<bool>& interrupted) {
  const auto together = Worker(load, interrupted, patience_).run();
  if (!together) {
    print_error({fmt::format("rank {}", rank_), "has lost rank 0", "the same command goes on from here"});
    return kExitError;
  }
  if (*together) MPI_Finalize();
  return kExitClean;
}

#endif

}  // namespace foldproof
