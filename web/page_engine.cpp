// The page's data and its check, for JavaScript in a worker: one scene at a time.
#include <emscripten.h>

#include <memory>
#include <new>
#include <string>

#include "base/try.h"
#include "page/page_json.h"
#include "page/query.h"
#include "page_files.h"

namespace foldproof {
namespace {

EM_JS(void, tell_share, (double share), { Module['repairing'](share); });

std::unique_ptr<Page> page;
std::atomic<bool> stop = false;
PageAnswer answer;

constexpr const char* kReport = "/report.html";  // there from the end of the check on

MeshFiles mesh_files_of(const Json& request) {
  const std::string meshes = request.value("meshes", "names");
  if (meshes == "sequence") return MeshFiles::Sequence;
  if (meshes == "separate") return MeshFiles::Separate;
  return request["static"] ? MeshFiles::Poses : MeshFiles::ByName;
}

Result<void> open(const Json& request) {
  const std::vector<std::string> files = request["files"], models = request["models"];
  PageInput input;
  input.read.fps = request["fps"];
  const std::string seams = request.value("seams", "by_format");
  if (seams != "by_format") input.read.weld = seams == "always" ? Weld::Always : Weld::Never;
  input.read.still = true;
  input.read.clip = request.value("clip", "");
  input.read.mesh_files = mesh_files_of(request);
  input.motions = FOLDPROOF_TRY(open_motions(files, input.read));
  input.check.substeps = request["substeps"];
  input.check.step.thickness = request["thickness"];
  input.check.poses = request["static"];
  input.check.models = FOLDPROOF_TRY(load_models(models, input.motions));
  const std::string command = request["command"];
  input.writer = [read = input.read, command](Motions motions, const CheckSettings& settings) {
    return page_report(kReport, motions, {{settings, read}, command}, page_files());
  };
  input.repair_progress = tell_share;
  input.files = page_files();
  input.command = command;
  page = FOLDPROOF_TRY(Page::open(std::move(input)));
  return {};
}

/// The status of the answer that `make` makes, or of an error.
template <class Make>
int answer_with(Make make) {
  try {
    answer = make();
  } catch (const std::bad_alloc&) {
    answer = {507, "application/json",
              error_json("memory: is not enough; check fewer frames or objects at a time")};
  }
  return answer.status;
}

}  // namespace
}  // namespace foldproof

// Status 200 or an error's, as of the page's server; what it says is in foldproof_body().
extern "C" {

/// `request`: the arguments of `foldproof view`: {"files": ["walk.glb"], "models": [], "thickness": 0,
/// "substeps": 1, "static": false, "fps": 24, "seams": "by_format", "clip": "", "meshes": "names", "command":
/// "what the report names"}.
int foldproof_open(const char* request) {
  using namespace foldproof;
  page.reset();
  stop = false;
  return answer_with([&] {
    const auto opened = open(Json::parse(request));
    return opened ? PageAnswer{} : PageAnswer{400, "application/json", error_json(opened.error().line())};
  });
}

/// Does a part of the check: 0 if nothing is left to do.
int foldproof_advance() { return foldproof::page->advance(foldproof::stop) ? 1 : 0; }

/// Ends the check.
void foldproof_stop() { foldproof::stop = true; }

int foldproof_get(const char* target) {
  using namespace foldproof;
  const std::string_view text = target;
  const std::size_t mark = std::min(text.find('?'), text.size());
  return answer_with([&] {
    return page->get(text.substr(0, mark), query_of(text.substr(std::min(mark + 1, text.size()))));
  });
}

const char* foldproof_body() { return foldproof::answer.body.data(); }
std::size_t foldproof_body_size() { return foldproof::answer.body.size(); }
}
