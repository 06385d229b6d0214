/// An HTML report: style, data and script in one file.
#pragma once

#include "page/page.h"
#include "report/json_values.h"
#include "report/text_file.h"

namespace foldproof {

/// JSON for a <script> element. It has '<' only in strings, where it is escaped so that it cannot end the
/// element.
std::string embedded(const Json& json);

/// The data are an object, whose fields end with a comma, but for the last one.
class ReportFile {
 public:
  /// Writes what comes before the fields, and the first of them. `files`: as page_report() takes them. Error:
  /// a file of the page is missing, the file cannot be written.
  static Result<ReportFile> open(const std::string& path, Motions motions, const CheckSettings& settings,
                                 const std::string& command, std::span<const PageFile> files);
  TextFile& fields() { return file_; }
  /// After the last field.
  Result<void> commit();

 private:
  ReportFile(FileWriter file, std::string_view script) : file_(std::move(file)), script_(script) {}

  TextFile file_;
  std::string_view script_;
};

}  // namespace foldproof
