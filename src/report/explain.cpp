// What certificates proved, for tuning and for pictures.
#include <algorithm>
#include <cctype>

#include "base/try.h"
#include "io/bytes.h"
#include "io/npz_table.h"
#include "report/joined.h"
#include "report/text_file.h"

namespace foldproof {
namespace {

using io::bytes_of;

constexpr std::size_t kReasons = kReasonNames.size();

/// Everything: a row per step.
class ExplainNpz : public ReportWriter {
 public:
  static Result<std::unique_ptr<ReportWriter>> open(const std::string& path, Motions motions) {
    std::vector<io::NpzTable::Column> columns{{"frame", "<u4", 4, {}}, {"substep", "<u4", 4, {}}};
    for (std::size_t i = 0; i < motions.size(); ++i) {
      const std::string suffix = motions.size() > 1 ? fmt::format("_{}", i) : "";
      const std::uint64_t triangles = motions[i]->topology().triangles().size();
      columns.push_back({"level" + suffix, "|i1", 1, {triangles}});
      columns.push_back({"margin" + suffix, "<f4", 4, {triangles}});
      columns.push_back({"reason" + suffix, "|u1", 1, {triangles}});
    }
    auto table = FOLDPROOF_TRY(io::NpzTable::open(path, std::move(columns)));
    return std::make_unique<ExplainNpz>(std::move(table));
  }
  explicit ExplainNpz(io::NpzTable table) : table_(std::move(table)) {}

  Result<void> step(const CheckedStep& step) override {
    table_.add(bytes_of(std::array{step.index.frame, step.index.substep}));
    for (const Explanation::Object& object : step.explanation->objects) {
      table_.add(bytes_of(object.level));
      table_.add(bytes_of(object.margin));
      table_.add(bytes_of(object.reason));
    }
    return table_.end_row();
  }

  Result<void> finish(const CheckTotals&) override { return table_.commit("reasons", kReasonNames); }

 private:
  io::NpzTable table_;
};

/// Counts: a row per step, object, reason and level that occur, and one per step and reason for pairs of
/// leaves.
class ExplainCsv : public ReportWriter {
 public:
  static Result<std::unique_ptr<ReportWriter>> open(const std::string& path) {
    auto file = FOLDPROOF_TRY(FileWriter::open(path));
    return std::make_unique<ExplainCsv>(std::move(file));
  }
  explicit ExplainCsv(FileWriter file) : file_(std::move(file)) {
    file_.add("frame,substep,kind,object,reason,level,count\n");
  }

  Result<void> step(const CheckedStep& step) override {
    for (std::size_t i = 0; i < step.explanation->objects.size(); ++i)
      add_triangles(step.index, i, step.explanation->objects[i]);
    for (std::size_t reason = 0; reason < kReasons; ++reason) {
      const std::uint64_t count = step.explanation->leaf_pairs[reason];
      if (count == 0) continue;
      file_.add("{},{},leaf_pairs,,{},,{}\n", step.index.frame, step.index.substep, kReasonNames[reason],
                count);
    }
    return file_.flush_if_large();
  }

  Result<void> finish(const CheckTotals&) override { return file_.commit(); }

 private:
  void add_triangles(const StepIndex& index, std::size_t object, const Explanation::Object& explained) {
    for (auto& of_reason : counts_) of_reason.fill(0);
    for (std::size_t t = 0; t < explained.level.size(); ++t)
      ++counts_[static_cast<std::size_t>(explained.reason[t])][explained.level[t] + 1];
    for (std::size_t reason = 0; reason < kReasons; ++reason) {
      for (std::size_t k = 0; k < counts_[reason].size(); ++k) {
        if (counts_[reason][k] == 0) continue;
        file_.add("{},{},triangles,{},{},{},{}\n", index.frame, index.substep, object, kReasonNames[reason],
                  static_cast<int>(k) - 1, counts_[reason][k]);
      }
    }
  }

  TextFile file_;
  std::array<std::array<std::uint64_t, 129>, kReasons> counts_;  // [reason][level + 1]
};

/// The step with the most pairs of leaves to test, except for those whose charts were not built yet: they
/// reflect the start of the check, not the mesh.
class ExplainPly : public ReportWriter {
 public:
  static Result<std::unique_ptr<ReportWriter>> open(const std::string& path, Motions motions) {
    // The mesh is written at the end of a check that may be long; make sure now that it can be written.
    FOLDPROOF_TRY(FileWriter::open(path));
    auto joined = FOLDPROOF_TRY(join(motions, "--explain"));
    return std::make_unique<ExplainPly>(path, std::move(joined));
  }
  ExplainPly(std::string path, JoinedMesh joined) : path_(std::move(path)), joined_(std::move(joined)) {}

  Result<void> step(const CheckedStep& step) override {
    const std::uint64_t tested =
        step.work.leaf_pairs - step.explanation->leaf_pairs[static_cast<std::size_t>(Reason::NotBuilt)];
    if (!positions_.empty() && tested <= max_tested_) return {};
    max_tested_ = tested;
    joined_.pose(step, 0, positions_);
    level_.clear();
    for (auto& property : bytes_) property.clear();
    for (const Explanation::Object& object : step.explanation->objects) {
      for (std::size_t t = 0; t < object.level.size(); ++t) add_face(object.reason[t], object.level[t]);
    }
    return {};
  }

  Result<void> finish(const CheckTotals&) override {
    const std::array<FaceProperty, 5> properties{{{"level", level_},
                                                  {"reason", bytes_[0]},
                                                  {"red", bytes_[1]},
                                                  {"green", bytes_[2]},
                                                  {"blue", bytes_[3]}}};
    return write_ply_properties(path_, joined_.topology, positions_, properties);
  }

 private:
  void add_face(Reason reason, std::int8_t level) {
    level_.push_back(level);
    bytes_[0].push_back(static_cast<std::uint8_t>(reason));
    const auto color = explanation_color(reason, level);
    for (std::size_t k = 0; k < 3; ++k) bytes_[1 + k].push_back(color[k]);
  }

  std::string path_;
  JoinedMesh joined_;
  std::uint64_t max_tested_ = 0;
  std::vector<double> positions_;
  std::vector<std::int8_t> level_;
  std::array<std::vector<std::uint8_t>, 4> bytes_;  // reason, red, green, blue
};

}  // namespace

Result<std::unique_ptr<ReportWriter>> explain_report(const std::string& path, Motions motions,
                                                     const CheckSettings& settings) {
  if (!settings.step.explain)
    return fail(ErrorCode::InvalidArgument, path, "has nothing to report", "set StepSettings::explain");
  const std::string ending = extension_of(path);
  if (ending == ".npz") return ExplainNpz::open(path, motions);
  if (ending == ".csv") return ExplainCsv::open(path);
  if (ending == ".ply") return ExplainPly::open(path, motions);
  return fail(ErrorCode::InvalidArgument, "--explain",
              fmt::format("'{}' ends in none of .npz, .csv and .ply", path),
              "name a file that does: all values, counts, or a colored mesh of one step");
}

}  // namespace foldproof
