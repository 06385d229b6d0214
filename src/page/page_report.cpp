// The HTML report: script, style, data and pictures in one file.
#include <fmt/format.h>

#include <ctime>

#include "base/try.h"
#include "page/page.h"
#include "page/page_json.h"
#include "report/contact_pictures.h"
#include "report/text_file.h"

namespace foldproof {
namespace {

constexpr const char* kScript = "report/report.js";
constexpr const char* kStyle = "report/report.css";
// Of a motion with more contacts, the worst are listed, and the worst of them drawn.
constexpr std::size_t kListed = 200, kPictures = 10;
constexpr ContactPictures::Format kFormat{960, 420, true};

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
      : file_(std::move(file)), motions_(motions), settings_(info.check.settings), recorder_(motions) {
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
  }

  Result<void> start(const CheckedStep& pose) override {
    start_ = start_json(start_of(pose));
    recorder_.start(pose);
    return {};
  }

  Result<void> step(const CheckedStep& step) override {
    file_.add("{}\n{}", step.index.number == 0 ? "" : ",", embedded(step_json(recorder_.add(step))));
    return file_.flush_if_large();
  }

  Result<void> finish(const CheckTotals& totals) override {
    file_.add("\n],\n\"start\":{},\n\"verdict\":{},\n\"totals\":{},\n\"contacts\":[", embedded(start_),
              embedded(verdict_json(verdict(motions_, settings_, totals))),
              embedded(totals_json(totals, settings_.poses, false)));
    pictures_.emplace(ContactPictures::open(motions_, settings_));
    FOLDPROOF_TRY(add_contacts(totals));
    const Json first_frame = totals.contacts.empty()
                                 ? picture_url([](ContactPictures& p) { return p.draw_first_frame(kFormat); })
                                 : Json();
    for (const auto& [object, text] : totals.notices)
      notes_.push_back(motions_[object]->name() + ": " + text);
    if (!*pictures_) notes_.push_back("Pictures are missing: " + pictures_->error().line());
    if (totals.contact_unknown_frames > 0) {
      notes_.push_back(fmt::format("It is not known which triangles cross in {} of the frames{}.",
                                   totals.contact_unknown_frames,
                                   settings_.steps_only ? " (--steps-only)" : ": too many pairs (--limit)"));
    }
    file_.add("\n],\n\"picture\":{},\n\"notes\":{}}}</script>\n", embedded(first_frame), embedded(notes_));
    file_.add("<script>{}</script>\n</body>\n</html>\n", script_);
    return file_.commit();
  }

 private:
  /// The worst contacts, the first of them with pictures.
  Result<void> add_contacts(const CheckTotals& totals) {
    const std::size_t count = std::min(totals.contacts.size(), kListed);
    const auto groups = groups_of(totals.contacts);
    std::size_t pictured = 0;  // the worst of each group is
    for (std::size_t i = 0; i < count; ++i) {
      const Contact& contact = totals.contacts[i];
      Json json = contact_json(contact, side_names(contact, motions_, settings_), groups[i], false);
      if (groups[i].number == pictured && ++pictured <= kPictures)
        json["picture"] =
            picture_url([&](ContactPictures& pictures) { return pictures.draw(contact, kFormat); });
      file_.add("{}\n{}", i == 0 ? "" : ",", embedded(json));
      FOLDPROOF_TRY(file_.flush_if_large());
    }
    return {};
  }

  /// A picture for <img>. After an error there are no more pictures: null.
  template <class Draw>
  Json picture_url(Draw draw) {
    if (!*pictures_) return nullptr;
    const Result<std::string> png = draw(**pictures_);
    if (png) return data_url(*png);
    *pictures_ = tl::unexpected(png.error());
    return nullptr;
  }

  /// Replaces invalid UTF-8 by U+FFFD.
  static std::string valid_utf8(const std::string& text) {
    return Json::parse(dump(text)).get<std::string>();
  }

  TextFile file_;
  Motions motions_;
  const CheckSettings settings_;
  StepRecorder recorder_;
  std::string_view script_;
  std::optional<Result<ContactPictures>> pictures_;  // from the end of the check on
  Json start_ = nullptr;                             // the answer for the first frame, if there is one
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
