#include "page/report_file.h"

#include <fmt/chrono.h>

#include <algorithm>
#include <ctime>
#include <map>

#include "base/try.h"
#include "page/page_json.h"

namespace foldproof {
namespace {

constexpr const char* kScript = "report/report.js";
constexpr const char* kStyle = "report/report.css";
constexpr const char* kScriptHash = "report/report.js.sha256";

std::string html_text(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '<':
        safe += "&lt;";
        break;
      case '&':
        safe += "&amp;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string now() { return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))); }

// Replaces invalid UTF-8 by U+FFFD.
std::string valid_utf8(const std::string& text) { return Json::parse(dump(text)).get<std::string>(); }

}  // namespace

std::string embedded(const Json& json) {
  std::string safe;
  for (const char c : dump(json)) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

Result<ReportFile> ReportFile::open(const std::string& path, Motions motions, const CheckSettings& settings,
                                    const std::string& command, std::span<const PageFile> files) {
  std::map<std::string_view, std::string_view> by_path;
  for (const PageFile& file : files) by_path[file.path] = file.bytes;
  for (const char* needed : {kScript, kStyle, kScriptHash}) {
    if (!by_path.contains(needed))
      return fail(ErrorCode::FileAccess, needed, "is missing", "build the page again");
  }
  ReportFile out(FOLDPROOF_TRY(FileWriter::open(path)), by_path.at(kScript));
  TextFile& file = out.file_;
  file.add("<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
  file.add("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
  file.add(
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'sha256-{}'; ",
      by_path.at(kScriptHash));
  file.add("style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'\">\n");
  file.add("<title>{} - Foldproof report</title>\n<style>", html_text(valid_utf8(title_of(motions))));
  file.add("{}</style>\n</head>\n<body>\n", by_path.at(kStyle));
  file.add(
      "<noscript>This report needs JavaScript to be shown; it loads nothing from elsewhere.</noscript>\n");
  file.add("<script type=\"application/json\" id=\"data\">{{\"program\":\"foldproof\",\"version\":{},",
           embedded(version()));
  file.add("\"made\":{},\"command\":{},", embedded(now()), embedded(command));
  file.add("\"objects\":{},", embedded(objects_json(motions, settings)));
  return out;
}

Result<void> ReportFile::commit() {
  file_.add("}}</script>\n<script>{}</script>\n</body>\n</html>\n", script_);
  return file_.commit();
}

}  // namespace foldproof
