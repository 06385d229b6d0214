#include <utility>

#include "base/try.h"
#include "report/json_reports.h"
#include "report/json_values.h"
#include "report/text_file.h"

namespace foldproof {
namespace {

class JsonReport : public ReportWriter {
 public:
  /// `clip`: of one of several reports in the file, which then is not committed; null: there is no other.
  JsonReport(std::shared_ptr<TextFile> file, Motions motions, const ReportInfo& info,
             const std::string* clip = nullptr)
      : shared_file_(std::move(file)),
        file_(*shared_file_),
        motions_(motions),
        settings_(info.settings),
        pairs_(info.pairs),
        poses_(info.settings.poses),
        statistical_(info.settings.paper_miss_rate.has_value()),
        is_whole_(clip == nullptr) {
    file_.add("{{");
    if (clip != nullptr) file_.add("\"clip\":{},\n", dump(*clip));
    file_.add("\"foldproof\":{},\n\"objects\":{},\n\"settings\":{},\n", dump(version()),
              dump(objects_json(motions, info.settings)), dump(settings_json(info, motions)));
  }

  Result<void> start(const CheckedStep& pose) override {
    file_.add("\"start\":{{\"frame\":{},\"crossings\":{},\"milliseconds\":{}", pose.index.frame,
              pose.collisions.triangle_triangle, dump(to_json(pose.milliseconds)));
    if (const std::uint64_t listed = pose.listed().triangle_triangle;
        listed < pose.collisions.triangle_triangle)
      file_.add(",\"listed\":{}", listed);
    if (pairs_) {
      file_.add(",\n\"pairs\":{{");
      FOLDPROOF_TRY(add_triangles(*pose.pose));
      file_.add("}}");
      FOLDPROOF_TRY(add_inside(pose));
    }
    file_.add("}},\n");
    return {};
  }

  Result<void> step(const CheckedStep& step) override {
    Json json = {{"frame", step.index.frame},
                 {"substep", step.index.substep},
                 {"collisions", to_json(step.collisions, poses_)},
                 {"earliest_toi", step.earliest_toi},
                 {"milliseconds", to_json(step.milliseconds)},
                 {"work", to_json(step.work)}};
    if (const CollisionCounts listed = step.listed(); listed.sum() < step.collisions.sum())
      json["listed"] = to_json(listed, poses_);
    if (statistical_) add_misses(json, step.missed, step.proven_milliseconds);
    std::string text = dump(json);
    text.pop_back();  // the pairs may follow before the closing brace
    begin_steps();
    file_.add("{}\n{}", step.index.number == 0 ? "" : ",", text);
    if (pairs_) {
      file_.add(",\"pairs\":{{");
      auto done = step.pose ? add_pairs(*step.pose) : add_pairs(*step.step);
      if (!done) return done;
      file_.add("}}");
      FOLDPROOF_TRY(add_inside(step));
    }
    file_.add("}}");
    return file_.flush_if_large();
  }

  Result<void> finish(const CheckTotals& totals) override {
    begin_steps();
    const Json json = totals_json(totals, poses_, statistical_);
    file_.add("\n],\n");
    if (totals.contacts_found) {
      FOLDPROOF_TRY(add_contacts(totals));
    }
    file_.add("\"verdict\":{},\n", dump(verdict_json(verdict(motions_, settings_, totals))));
    file_.add("\"totals\":{},\n\"clean\":{}}}\n", dump(json), totals.clean());
    return is_whole_ ? file_.commit() : Result<void>{};
  }

 private:
  /// Opens the list of steps, after the answer for the first frame.
  void begin_steps() {
    if (!std::exchange(steps_begun_, true)) file_.add("\"steps\":[");
  }

  Result<void> add_contacts(const CheckTotals& totals) {
    file_.add("\"contacts\":[");
    const char* separator = "\n";
    const auto groups = groups_of(totals.contacts);
    for (std::size_t k = 0; k < groups.size(); ++k) {
      const Contact& contact = totals.contacts[k];
      file_.add("{}{}", separator,
                dump(contact_json(contact, side_names(contact, motions_, settings_), groups[k], pairs_)));
      separator = ",\n";
      FOLDPROOF_TRY(file_.flush_if_large());
    }
    file_.add("\n],\n");
    return {};
  }

  /// Per object, the triangles that cross or are inside at the step's end; null where that is not known.
  Result<void> add_inside(const CheckedStep& step) {
    file_.add(",\"inside\":");
    const char* separator = "[";
    for (Index object = 0; object < motions_.size(); ++object) {
      const auto marks = inside_faces(motions_[object]->topology(), object, step);
      if (!marks) {
        file_.add("null");
        return {};
      }
      file_.add("{}[", std::exchange(separator, ","));
      const char* between = "";
      for (std::size_t t = 0; t < marks->size(); ++t) {
        if ((*marks)[t]) file_.add("{}{}", std::exchange(between, ","), t);
      }
      file_.add("]");
      FOLDPROOF_TRY(file_.flush_if_large());
    }
    file_.add("]");
    return {};
  }

  Result<void> add_pairs(const StepResult& result) {
    file_.add("\"vf\":[");
    const char* separator = "";
    for (const VertexFaceCollision& c : result.vertex_face) {
      file_.add("{}[{},{},{},{},{}]", separator, c.vertex_object, c.vertex, c.face_object, c.face, c.toi);
      separator = ",";
      FOLDPROOF_TRY(file_.flush_if_large());
    }
    file_.add("],\"ee\":[");
    separator = "";
    for (const EdgeEdgeCollision& c : result.edge_edge) {
      file_.add("{}[{},{},{},{},{},{},{}]", separator, c.object_a, c.a[0], c.a[1], c.object_b, c.b[0], c.b[1],
                c.toi);
      separator = ",";
      FOLDPROOF_TRY(file_.flush_if_large());
    }
    file_.add("]");
    return {};
  }

  Result<void> add_pairs(const StaticResult& result) {
    file_.add("\"vf\":[],\"ee\":[],");
    return add_triangles(result);
  }

  Result<void> add_triangles(const StaticResult& result) {
    file_.add("\"tt\":[");
    const char* separator = "";
    for (const TriangleCrossing& c : result.crossings) {
      file_.add("{}[{},{},{},{}]", separator, c.object_a, c.triangle_a, c.object_b, c.triangle_b);
      separator = ",";
      FOLDPROOF_TRY(file_.flush_if_large());
    }
    file_.add("]");
    return {};
  }

  std::shared_ptr<TextFile> shared_file_;
  TextFile& file_;
  Motions motions_;
  const CheckSettings settings_;
  bool pairs_, poses_, statistical_, is_whole_, steps_begun_ = false;
};

}  // namespace

Result<std::unique_ptr<ReportWriter>> json_report(const std::string& path, Motions motions,
                                                  const ReportInfo& info) {
  auto file = FOLDPROOF_TRY(FileWriter::open(path));
  return std::make_unique<JsonReport>(std::make_shared<TextFile>(std::move(file)), motions, info);
}

struct JsonReports::State {
  std::shared_ptr<TextFile> file;
  bool is_empty = true;
};

JsonReports::JsonReports(std::unique_ptr<State> state) : state_(std::move(state)) {}
JsonReports::JsonReports(JsonReports&&) noexcept = default;
JsonReports& JsonReports::operator=(JsonReports&&) noexcept = default;
JsonReports::~JsonReports() = default;

Result<JsonReports> JsonReports::open(const std::string& path) {
  auto file = std::make_shared<TextFile>(FOLDPROOF_TRY(FileWriter::open(path)));
  file->add("{{\"foldproof\":{},\n\"clips\":[\n", dump(version()));
  return JsonReports(std::make_unique<State>(State{std::move(file)}));
}

std::unique_ptr<ReportWriter> JsonReports::add(const std::string& clip, Motions motions,
                                               const ReportInfo& info) {
  if (!std::exchange(state_->is_empty, false)) state_->file->add(",\n");
  return std::make_unique<JsonReport>(state_->file, motions, info, &clip);
}

Result<void> JsonReports::finish(bool clean) {
  state_->file->add("],\n\"clean\":{}}}\n", clean);
  return state_->file->commit();
}

}  // namespace foldproof
