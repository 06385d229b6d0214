// The HTML report: script, style, data and pictures in one file.
#include <fmt/format.h>

#include <ctime>

#include "base/try.h"
#include "page/page.h"
#include "page/page_json.h"
#include "page/snapshots.h"
#include "report/text_file.h"

namespace foldproof {
namespace {

constexpr const char* kScript = "report/report.js";
constexpr const char* kStyle = "report/report.css";

/// JSON for a <script> element. It has '<' only in strings, where it is escaped so that it cannot end the
/// element.
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

std::string base64(std::string_view bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string now() {
  const std::time_t seconds = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  char text[32] = {};
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

class PageReport final : public ReportWriter {
 public:
  PageReport(FileWriter file, Motions motions, const PageReportInfo& info,
             const std::map<std::string_view, std::string_view>& files)
      : file_(std::move(file)), motions_(motions), substeps_(info.check.settings.substeps) {
    file_.add("<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    file_.add("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
    file_.add(
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'sha256-{}'; ",
        files.at("report/report.js.sha256"));
    file_.add("style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'\">\n");
    file_.add("<title>{} - Foldproof report</title>\n<style>", html_text(valid_utf8(title_of(motions))));
    file_.add("{}</style>\n</head>\n<body>\n", files.at(kStyle));
    file_.add(
        "<noscript>This report needs JavaScript to be shown; it loads nothing from elsewhere.</noscript>\n");
    file_.add("<script type=\"application/json\" id=\"data\">{{\"program\":\"foldproof\",\"version\":{},",
              embedded(version()));
    file_.add("\"made\":{},\"command\":{},", embedded(now()), embedded(info.command));
    file_.add("\"objects\":{},", embedded(objects_json(motions, info.check.settings)));
    file_.add("\"settings\":{},\n\"steps\":[", embedded(settings_json(info.check, motions)));
    script_ = files.at(kScript);
    auto snapshots = Snapshots::open(motions, substeps_);
    if (snapshots) {
      snapshots_.emplace(std::move(*snapshots));
    } else {
      notes_.push_back("There are no pictures: " + snapshots.error().line());
    }
  }

  Result<void> start(const CheckedStep& pose) override {
    if (snapshots_) snapshots_->start(pose);
    start_ = start_json({pose.index.frame, pose.collisions.triangle_triangle, pose.milliseconds});
    return {};
  }

  Result<void> step(const CheckedStep& step) override {
    if (snapshots_) snapshots_->add(step);
    file_.add("{}\n{}", step.index.number == 0 ? "" : ",", embedded(step_json(record_of(step))));
    return file_.flush_if_large();
  }

  Result<void> finish(const CheckTotals& totals) override {
    if (totals.listed.sum() < totals.collisions.sum()) {
      notes_.push_back(fmt::format("Of {} colliding pairs the pictures mark {}; more with --limit.",
                                   totals.collisions.sum(), totals.listed.sum()));
    }
    file_.add("\n],\n\"start\":{},\n\"totals\":{},\n\"pictures\":[", embedded(start_),
              embedded(totals_json(totals, false, false)));
    if (snapshots_) {
      const auto pictures = FOLDPROOF_TRY(snapshots_->draw(totals));
      for (const Snapshot& picture : pictures) {
        file_.add("{}\n{}", &picture == pictures.data() ? "" : ",",
                  embedded({{"step", picture.step ? Json(*picture.step) : Json(nullptr)},
                            {"caption", picture.caption},
                            {"png", "data:image/png;base64," + base64(picture.png)}}));
      }
    }
    file_.add("\n],\n\"notes\":{}}}</script>\n<script>{}</script>\n</body>\n</html>\n", embedded(notes_),
              script_);
    return file_.commit();
  }

 private:
  /// Replaces invalid UTF-8 by U+FFFD.
  static std::string valid_utf8(const std::string& text) {
    return Json::parse(dump(text)).get<std::string>();
  }

  TextFile file_;
  Motions motions_;
  Index substeps_;
  std::string_view script_;
  std::optional<Snapshots> snapshots_;
  Json start_ = nullptr;  // the answer for the first frame, if there is one
  std::vector<std::string> notes_;
};

}  // namespace

Result<std::unique_ptr<ReportWriter>> page_report(const std::string& path, Motions motions,
                                                  const PageReportInfo& info,
                                                  std::span<const PageFile> files) {
  if (!info.check.settings.step.explain)
    return fail(ErrorCode::InvalidArgument, path, "has nothing to report", "set StepSettings::explain");
  std::map<std::string_view, std::string_view> by_path;
  for (const PageFile& file : files) by_path[file.path] = file.bytes;
  for (const char* needed : {kScript, kStyle, "report/report.js.sha256"}) {
    if (!by_path.contains(needed))
      return fail(ErrorCode::FileAccess, needed, "is missing", "build the page again");
  }
  auto file = FOLDPROOF_TRY(FileWriter::open(path));
  return std::make_unique<PageReport>(std::move(file), motions, info, by_path);
}

}  // namespace foldproof
