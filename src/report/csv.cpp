#include "base/try.h"
#include "report/report.h"
#include "report/text_file.h"

namespace foldproof {
namespace {

const char* answer_name(Answer answer) { return answer == Answer::Undecided ? "undecided" : "hit"; }

class CsvReport : public ReportWriter {
 public:
  explicit CsvReport(FileWriter file) : file_(std::move(file)) {
    file_.add("frame,substep,kind,object_a,a0,a1,object_b,b0,b1,toi,answer\n");
  }

  Result<void> start(const CheckedStep& pose) override { return add_crossings(pose); }

  Result<void> step(const CheckedStep& step) override {
    if (step.pose) return add_crossings(step);
    note_limit(step);
    const StepIndex& index = step.index;
    for (const VertexFaceCollision& c : step.step->vertex_face) {
      file_.add("{},{},vf,{},{},,{},{},,{},{}\n", index.frame, index.substep, c.vertex_object, c.vertex,
                c.face_object, c.face, c.toi, answer_name(c.answer));
      FOLDPROOF_TRY(file_.flush_if_large());
    }
    for (const EdgeEdgeCollision& c : step.step->edge_edge) {
      file_.add("{},{},ee,{},{},{},{},{},{},{},{}\n", index.frame, index.substep, c.object_a, c.a[0], c.a[1],
                c.object_b, c.b[0], c.b[1], c.toi, answer_name(c.answer));
      FOLDPROOF_TRY(file_.flush_if_large());
    }
    return {};
  }

  Result<void> finish(const CheckTotals&) override { return file_.commit(); }

 private:
  void note_limit(const CheckedStep& step) {
    if (step.listed().sum() == step.collisions.sum()) return;
    file_.add("# frame {} substep {}: listed {} of {}\n", step.index.frame, step.index.substep,
              step.listed().sum(), step.collisions.sum());
  }

  Result<void> add_crossings(const CheckedStep& step) {
    note_limit(step);
    const StepIndex& index = step.index;
    for (const TriangleCrossing& c : step.pose->crossings) {
      file_.add("{},{},tt,{},{},,{},{},,,crossing\n", index.frame, index.substep, c.object_a, c.triangle_a,
                c.object_b, c.triangle_b);
      FOLDPROOF_TRY(file_.flush_if_large());
    }
    return {};
  }

  TextFile file_;
};

}  // namespace

Result<std::unique_ptr<ReportWriter>> csv_report(const std::string& path) {
  auto file = FOLDPROOF_TRY(FileWriter::open(path));
  return std::make_unique<CsvReport>(std::move(file));
}

}  // namespace foldproof
