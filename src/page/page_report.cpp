// The HTML report of a check.
#include <fmt/format.h>

#include "base/try.h"
#include "page/page_json.h"
#include "page/report_file.h"
#include "report/contact_pictures.h"

namespace foldproof {
namespace {

// Of a motion with more contacts, the worst are listed, and the worst of them drawn.
constexpr std::size_t kListed = 200, kPictures = 10;
constexpr ContactPictures::Format kFormat{960, 420, true};

class PageReport final : public ReportWriter {
 public:
  PageReport(ReportFile file, Motions motions, const ReportInfo& info)
      : file_(std::move(file)), motions_(motions), settings_(info.settings), recorder_(motions) {
    file_.fields().add("\"settings\":{},\n\"steps\":[", embedded(settings_json(info, motions)));
  }

  Result<void> start(const CheckedStep& pose) override {
    start_ = start_json(start_of(pose));
    recorder_.start(pose);
    return {};
  }

  Result<void> step(const CheckedStep& step) override {
    TextFile& fields = file_.fields();
    fields.add("{}\n{}", step.index.number == 0 ? "" : ",", embedded(step_json(recorder_.add(step))));
    return fields.flush_if_large();
  }

  Result<void> finish(const CheckTotals& totals) override {
    TextFile& fields = file_.fields();
    fields.add("\n],\n\"start\":{},\n\"verdict\":{},\n\"totals\":{},\n\"contacts\":[", embedded(start_),
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
    fields.add("\n],\n\"picture\":{},\n\"notes\":{}", embedded(first_frame), embedded(notes_));
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
      file_.fields().add("{}\n{}", i == 0 ? "" : ",", embedded(json));
      FOLDPROOF_TRY(file_.fields().flush_if_large());
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

  ReportFile file_;
  Motions motions_;
  const CheckSettings settings_;
  StepRecorder recorder_;
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
  auto file = FOLDPROOF_TRY(ReportFile::open(path, motions, info.check.settings, info.command, files));
  return std::make_unique<PageReport>(std::move(file), motions, info.check);
}

}  // namespace foldproof
