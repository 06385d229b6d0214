/// JSON reports of several checks in one document.
#pragma once

#include "report/report.h"

namespace foldproof {

/// Reports of several checks in one document: {"foldproof": ..., "clips": [REPORT, ...], "clean": ...}.
class JsonReports {
 public:
  static Result<JsonReports> open(const std::string& path);
  JsonReports(JsonReports&&) noexcept;
  JsonReports& operator=(JsonReports&&) noexcept;
  ~JsonReports();

  /// The next report, which begins with the clip's name. Both must end before this.
  std::unique_ptr<ReportWriter> add(const std::string& clip, Motions motions, const ReportInfo& info);
  /// `clean`: of all.
  Result<void> finish(bool clean);

 private:
  struct State;
  explicit JsonReports(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace foldproof
