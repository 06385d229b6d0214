#include "foldproof/report.h"
#include "report/text_file.h"

namespace foldproof {
namespace {

const char* answer_name(Answer answer) { return answer == Answer::Undecided ? "undecided" : "hit"; }

class CsvReport : public ReportWriter {
 public:
  explicit CsvReport(FileWriter file) : file_(std::move(file)) {
    file_.add("frame,substep,kind,object_a,a0,a1,object_b,b0,b1,toi,answer\n");
  }

  Result<void> start(const CheckedStep& pose) override { return add(pose.place, *pose.pose); }

  Result<void> step(const CheckedStep& step) override {
    const StepPlace& at = step.place;
    if (step.pose) return add(at, *step.pose);
    for (const VertexFaceCollision& c : step.step->vertex_face) {
      file_.add("{},{},vf,{},{},,{},{},,{},{}\n", at.frame, at.substep, c.vertex_object, c.vertex,
                c.face_object, c.face, c.toi, answer_name(c.answer));
      if (auto done = file_.flush_if_large(); !done) return done;
    }
    for (const EdgeEdgeCollision& c : step.step->edge_edge) {
      file_.add("{},{},ee,{},{},{},{},{},{},{},{}\n", at.frame, at.substep, c.object_a, c.a[0], c.a[1],
                c.object_b, c.b[0], c.b[1], c.toi, answer_name(c.answer));
      if (auto done = file_.flush_if_large(); !done) return done;
    }
    return {};
  }

  Result<void> finish(const CheckTotals&) override { return file_.commit(); }

 private:
  Result<void> add(const StepPlace& at, const StaticResult& pose) {
    for (const TriangleCrossing& c : pose.crossings) {
      file_.add("{},{},tt,{},{},,{},{},,,crossing\n", at.frame, at.substep, c.object_a, c.triangle_a,
                c.object_b, c.triangle_b);
      if (auto done = file_.flush_if_large(); !done) return done;
    }
    return {};
  }

  TextFile file_;
};

}  // namespace

Result<std::unique_ptr<ReportWriter>> csv_report(const std::string& path) {
  auto file = FileWriter::open(path);
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<CsvReport>(std::move(*file));
}

}  // namespace foldproof
