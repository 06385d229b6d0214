#include "simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include <nlohmann/json.hpp>

#include "base/try.h"
#include "implicit_euler.h"
#include "measure.h"

namespace foldproof::bench {
namespace {

using nlohmann::json;

struct SceneMaker {
  const char* name;
  example::Scene (*make)();
};
constexpr SceneMaker kScenes[] = {{"cloth", [] { return example::cloth_on_ball(100, 4); }},
                                  {"pile", [] { return example::pile_of_balls(4); }},
                                  {"rod", [] { return example::twisted_rod(40); }}};

// At most, of a step: enough to see what is asked, where the solver itself takes most of the time.
constexpr int kNewtonSteps = 4;

// Times of one kind of question, milliseconds.
struct Row {
  int questions = 0, sampled = 0;
  double sum = 0, slowest = 0;
  double ours = 0, without = 0;         // of the sampled questions, which everybody answers
  std::map<std::string, double> peers;  // the same, by name
};
// Asked before anything was in contact, and since.
using Rows = std::array<Row, 2>;

// Answers the solver's questions, and lets others answer some of them beside.
class Measured final : public example::CollisionQueries {
 public:
  Measured(const SimulationPlan& plan, std::shared_ptr<const CollisionMesh> mesh, const Topology& topology,
           double reach)
      : plan_(plan), mesh_(std::move(mesh)), checker_(mesh_), plain_(mesh_) {
    plain_.settings().certificates = false;
    for (const PeerEntry& entry : plan.peers) {
      for (const double inflation : {0.0, reach}) {
        auto peer = entry.make();
        peer->prepare(topology);
        peer->inflate(inflation);
        (inflation > 0 ? peers_near_ : peers_).push_back(std::move(peer));
      }
    }
  }

  double step_size(std::span<const double> x0, std::span<const double> x1) override {
    const auto ask = [&](ContactChecker& checker) {
      return checker.collision_free_step_size(x0, x1).map([](const auto& size) { return size.share; });
    };
    Row& row = steps_[in_contact_];
    if (!is_sampled(row)) return take(row, checker_, ask);
    const double start = now();
    const auto without = ask(plain_);
    row.without += now() - start;
    ask_peers(row, peers_, x0, x1);
    const double share = take(row, checker_, ask);
    if (!without || *without != share)
      note(Error{"a step size", "differs without certificates", "report this, please"});
    return share;
  }
  bool step_is_free(std::span<const double> x0, std::span<const double> x1) override {
    const auto free = checker_.is_step_collision_free(x0, x1);
    if (free.is_error()) note(free.error());
    return free.is_yes();
  }
  void contacts(std::span<const double> x, double reach, std::vector<example::Contact>& out) override {
    Row& row = candidates_[in_contact_];
    if (is_sampled(row)) ask_peers(row, peers_near_, x, x);
    take(row, checker_, [&](ContactChecker& checker) -> Result<bool> {
      FOLDPROOF_TRY(checker.candidates(x, reach, found_));
      return true;
    });
    take(close_pairs_[in_contact_], plain_, [&](ContactChecker& checker) -> Result<bool> {
      FOLDPROOF_TRY(checker.close_pairs(x, reach, out));
      return true;
    });
  }

  void end_step(bool in_contact) {
    ++steps_taken_[in_contact_];
    if (in_contact) in_contact_ = 1;
  }
  const std::optional<Error>& error() const { return error_; }
  void report(const json& facts, json& out) const {
    for (const auto& [question, rows] :
         {std::pair("step size", &steps_), std::pair("candidates", &candidates_),
          std::pair("close pairs", &close_pairs_)})
      add_rows(facts, question, *rows, out);
  }

 private:
  void add_rows(const json& facts, const char* question, const Rows& rows, json& out) const;
  double now() const { return now_milliseconds(plan_.processor_time); }
  void note(const Error& error) {
    if (!error_) error_ = error;
  }
  bool is_sampled(const Row& row) const { return row.questions % static_cast<int>(plan_.peer_every) == 0; }

  void ask_peers(Row& row, std::vector<std::unique_ptr<Peer>>& peers, std::span<const double> x0,
                 std::span<const double> x1) {
    for (std::size_t k = 0; k < peers.size(); ++k) {
      const double start = now();
      peers[k]->step(x0, x1);
      row.peers[plan_.peers[k].name] += now() - start;
    }
  }

  template <class Ask>
  double take(Row& row, ContactChecker& checker, Ask ask) {
    const bool sampled = is_sampled(row);
    const double start = now();
    auto answer = ask(checker);
    const double took = now() - start;
    ++row.questions;
    row.sum += took;
    row.slowest = std::max(row.slowest, took);
    if (sampled) {
      ++row.sampled;
      row.ours += took;
    }
    if (!answer) note(answer.error());
    return answer ? static_cast<double>(*answer) : 0;
  }

  const SimulationPlan& plan_;
  std::shared_ptr<const CollisionMesh> mesh_;
  ContactChecker checker_, plain_;
  std::vector<std::unique_ptr<Peer>> peers_, peers_near_;
  Rows steps_, candidates_, close_pairs_;
  std::array<int, 2> steps_taken_{};
  foldproof::Candidates found_;
  std::optional<Error> error_;
  int in_contact_ = 0;
};

void Measured::add_rows(const json& facts, const char* question, const Rows& rows, json& out) const {
  for (int contact = 0; contact < 2; ++contact) {
    const Row& row = rows[contact];
    if (row.questions == 0) continue;
    json sampled = {{"questions", row.sampled}, {"certificates", row.ours}, {"peers", row.peers}};
    if (row.without > 0) sampled["plain"] = row.without;
    json entry = {{"question", question},       {"contact", contact == 0 ? "before" : "since"},
                  {"questions", row.questions}, {"steps", steps_taken_[contact]},
                  {"milliseconds", row.sum},    {"slowest_milliseconds", row.slowest},
                  {"sampled", sampled}};
    entry.update(facts);
    out.push_back(std::move(entry));
  }
}

Result<void> run(const SceneMaker& maker, const SimulationPlan& plan, json& out) {
  const example::Scene scene = maker.make();
  auto topology = FOLDPROOF_TRY(Topology::make(scene.vertex_count(), scene.faces));
  CollisionMeshSettings settings;
  settings.points = false;  // what holds bodies open from inside
  auto mesh = FOLDPROOF_TRY(CollisionMesh::make(scene.x, {}, scene.faces, settings));
  Measured measured(plan, std::make_shared<const CollisionMesh>(std::move(mesh)), topology, scene.reach);
  example::ImplicitEuler solver(scene, measured, kNewtonSteps);
  for (Index step = 1; step <= plan.steps; ++step) {
    const example::StepReport report = solver.step();
    if (measured.error()) break;
    if (!report.collision_free) return fail(maker.name, "has a step that is not free", "report this, please");
    measured.end_step(report.contacts > 0);
    if (plan.narrate)
      fmt::print(stderr, "\r\033[K{}: step {} of {}, {} Newton steps, {} contacts", maker.name, step,
                 plan.steps, report.newton_steps, report.contacts);
  }
  if (plan.narrate) fmt::print(stderr, "\r\033[K");
  if (measured.error()) return tl::unexpected(*measured.error());
  const json facts = {{"name", maker.name}, {"triangles", scene.faces.size()}};
  measured.report(facts, out);
  return {};
}

}  // namespace

Result<json> measure_simulation(const SimulationPlan& plan) {
  json rows = json::array();
  for (const SceneMaker& maker : kScenes) {
    if (!plan.only.empty() && plan.only != maker.name) continue;
    FOLDPROOF_TRY(run(maker, plan, rows));
  }
  if (rows.empty()) return fail("--scene", "there is no simulation called " + plan.only, "cloth, pile, rod");
  return rows;
}

}  // namespace foldproof::bench
