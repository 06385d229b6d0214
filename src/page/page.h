/// The server of the web page that shows motions, collisions and proofs, and the HTML report.
///
/// A target of its own (foldproof_page), so that users of the library need no HTTP server. The caller
/// provides the page itself, HTML and scripts built from page/ (PageFile).
#pragma once

#include <atomic>
#include <functional>
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

/// Input of the HTML report besides the motions.
struct PageReportInfo {
  ReportInfo check;
  std::string command;  ///< The command line.
};

/// A self-contained HTML file: summary, the worst 200 contacts, pictures of the worst ten, charts, settings.
/// Steps are written as they come; at the end the motions are read again for the pictures. `files`: those
/// under "report/" with their hashes (tools/embed.py); they must outlive the writer, as must the motions.
/// Error: settings.step.explain is not set, the file cannot be written, a file of the
/// page is missing, a frame cannot be read again.
Result<std::unique_ptr<ReportWriter>> page_report(const std::string& path, Motions motions,
                                                  const PageReportInfo& info,
                                                  std::span<const PageFile> files);

/// What the page shows.
struct PageInput {
  std::vector<std::unique_ptr<Motion>> motions;
  CheckSettings check;  ///< The page overrides `explain`.
  ReadOptions read;     ///< How the motions were read, for display.
  /// Makes another receiver of the answers, such as a page_report(); or empty.
  std::function<Result<std::unique_ptr<ReportWriter>>(Motions, const CheckSettings&)> writer = {};
  /// Called with the share of a repair that is done, where requests cannot be answered meanwhile; or empty.
  std::function<void(double)> repair_progress = {};
  std::vector<PageFile> files = {};  ///< Those under "report/", for the reports of repairs.
  std::string command = {};          ///< The command line, for these.
};

/// The response to a request.
struct PageAnswer {
  int status = 200;
  std::string type = "application/json", body = {};
};

/// The parameters of a URL.
using PageQuery = std::map<std::string, std::string, std::less<>>;

/// Answers requests for the data of a scene (docs/viewer.md lists them) while its check runs. Memory holds a
/// few frames per object; the answers of the check are in unnamed temporary files.
class Page {
 public:
  /// Reads the first selected frame and builds hierarchies for objects without a model. Error: those of
  /// frames_to_check, a model of another mesh, a frame that cannot be read, no temporary file.
  static Result<std::unique_ptr<Page>> open(PageInput input);
  ~Page();
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;

  /// `path` starts with "/api/" and is decoded. Thread-safe.
  PageAnswer get(std::string_view path, const PageQuery& query = {}) const;

  /// Does the next part of the check, then certifies radii and repairs on request. False if there is nothing
  /// to do. Ends the check if `stop` is set. Not thread-safe.
  bool advance(const std::atomic<bool>& stop);
  /// Advances or waits for requests until `stop` is set. Call it once, from one thread.
  void work(const std::atomic<bool>& stop);

 private:
  struct Impl;
  explicit Page(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Without a given port, a server takes the first free one of these.
inline constexpr int kFirstPagePort = 7420, kPagePorts = 100;

/// Serves a page over HTTP on 127.0.0.1. Answers only requests whose Host header names this machine.
class PageServer {
 public:
  /// Starts to listen; `serve` answers requests. `files`: those under "view/", which must outlive the server.
  /// `port` 0: see kFirstPagePort. Error: the port is taken, or none is free.
  static Result<PageServer> open(Page& page, std::span<const PageFile> files, int port = 0);
  ~PageServer();
  PageServer(PageServer&&) noexcept;
  PageServer& operator=(PageServer&&) noexcept;

  int port() const;
  /// Answers requests and runs Page::work until `stop` is called, then returns after the current step and the
  /// timeouts of connections that are still open (docs/viewer.md). Call it once. Error: listening failed.
  Result<void> serve();
  /// Ends `serve`, which another thread calls or is about to call.
  void stop();

 private:
  struct Impl;
  explicit PageServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace foldproof
