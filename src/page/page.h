/// The page: motions, collisions and proofs as a web browser shows them, and the report to mail.
///
/// A target of its own (foldproof_page), above the library: who only asks for collisions needs no HTTP
/// server. The page itself, HTML and scripts, is made from page/ and is the caller's to bring (PageFile).
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "report/report.h"

namespace foldproof {

/// A file of the built page: "view/index.html", "view/assets/index.js", "report/report.js".
struct PageFile {
  std::string_view path, bytes;
};

/// What a mailed report says besides the answer.
struct PageReportInfo {
  ReportInfo check;
  std::string command;  ///< What was typed.
};

/// One HTML file with everything in it: summary, charts, pictures of what crosses at the start and of the
/// worst steps, settings. Steps go to it as they come; memory holds what seven pictures show. `files`: those
/// under "report/" with their sums (tools/embed.py); they must outlive the writer. Precondition:
/// settings.step.explain, and no poses. Error: it cannot be written, a file of the page is not there.
Result<std::unique_ptr<ReportWriter>> page_report(const std::string& path, Motions motions,
                                                  const PageReportInfo& info,
                                                  std::span<const PageFile> files);

/// What is to be seen.
struct PageInput {
  std::vector<std::unique_ptr<Motion>> motions;
  CheckSettings check;  ///< `poses` and `explain` are set as the page needs them.
  ReadOptions read;     ///< How the motions were read, to be told.
};

/// What a request gets.
struct PageAnswer {
  int status = 200;
  std::string type = "application/json", body = {};
};

/// The part of a URL behind '?'.
using PageQuery = std::map<std::string, std::string, std::less<>>;

/// Answers requests for the data of a scene (docs/viewer.md lists them) while a check of it runs. Memory
/// holds a few frames per object; the check's answers lie in a temporary file without a name.
class Page {
 public:
  /// Reads the first selected frame and builds what hierarchies the models do not bring. Error: no motions,
  /// different frame counts, a single frame with CheckSettings::steps_only, a model of another mesh, a frame
  /// that cannot be read, no temporary file.
  static Result<std::unique_ptr<Page>> open(PageInput input);
  ~Page();
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;

  /// `path` begins with "/api/" and is decoded. Any thread, at any time.
  PageAnswer get(std::string_view path, const PageQuery& query = {}) const;

  /// Asks what crosses in the first frame, checks all steps and then certifies radii as requests ask for
  /// them; returns soon after `stop` is set, that is after the step that it works on. To be called once, by
  /// one thread.
  void work(const std::atomic<bool>& stop);

 private:
  struct Impl;
  explicit Page(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Where a server looks for a port when it is not given one: the first free one from here on.
inline constexpr int kFirstPagePort = 7420, kPagePorts = 100;

/// Serves a page over HTTP on 127.0.0.1, to requests that name this machine as their host and no other.
class PageServer {
 public:
  /// Listens at once; requests are answered by `serve`. `files`: those under "view/", which must outlive the
  /// server. `port` 0: see kFirstPagePort. Error: the port is taken, or none is free.
  static Result<PageServer> open(Page& page, std::span<const PageFile> files, int port = 0);
  ~PageServer();
  PageServer(PageServer&&) noexcept;
  PageServer& operator=(PageServer&&) noexcept;

  int port() const;
  /// Answers requests, and lets the page work, until `stop` is set: then at once, but for the step that is
  /// being checked. Nobody who is slow, or asks for much, keeps others waiting (docs/viewer.md says what is
  /// bounded). Error: the port can no longer be listened at, no threads.
  Result<void> serve(const std::atomic<bool>& stop);

 private:
  struct Impl;
  explicit PageServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace foldproof
