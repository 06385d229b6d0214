// The summary page: plain HTML, and a few lines of script that sort its table.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/duration.h"
#include "base/try.h"
#include "report/json_values.h"
#include "report/text_file.h"
#include "sweep/sweep.h"

namespace foldproof {
namespace {

/// Sorts by the column whose heading is clicked, in reverse on the next click. Its SHA-256 in base64 follows,
/// without which browsers do not run it; a test recomputes it.
constexpr const char* kScript = R"(
document.querySelectorAll("th").forEach((head, column) => {
  head.tabIndex = 0;
  const sort = () => {
    const body = document.querySelector("tbody"), down = head.ariaSort === "ascending";
    const names = new Intl.Collator(undefined, { numeric: true });
    const order = (a, b) => (a.dataset.v ? a.dataset.v - b.dataset.v : names.compare(a.textContent, b.textContent));
    const rows = [...body.rows].sort((a, b) => order(a.cells[column], b.cells[column]) * (down ? -1 : 1));
    document.querySelectorAll("th").forEach((other) => (other.ariaSort = null));
    head.ariaSort = down ? "descending" : "ascending";
    body.append(...rows);
  };
  head.onclick = sort;
  head.onkeydown = (event) => event.key === "Enter" && sort();
});
)";
constexpr const char* kScriptHash = "Gl8jasMUXX5RngUDaOPNkMSfQ6T306jAm6OSJekxjos=";

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; }
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 80rem; padding: 0 1rem; }
code { overflow-wrap: anywhere; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .6rem; text-align: right; border-bottom: 1px solid #8884; vertical-align: top; }
th { position: sticky; top: 0; background: Canvas; cursor: pointer; }
th[aria-sort=ascending]::after { content: " \25b4"; }
th[aria-sort=descending]::after { content: " \25be"; }
th:first-child, td:first-child { text-align: left; overflow-wrap: anywhere; }
td p { margin: 0; opacity: .75; font-size: 90%; max-width: 40rem; }
td img { display: block; width: 120px; height: 90px; object-fit: contain; }
.collides { color: #c22; font-weight: 600; }
.failed, .unclear { color: #b60; font-weight: 600; }
.starts { color: #a3457f; font-weight: 600; }
@media (max-width: 60rem) { table { display: block; overflow-x: auto; } th { position: static; } }
@media (prefers-color-scheme: dark) { .collides { color: #f77; } .failed, .unclear { color: #fb5; } .starts { color: #e79bc8; } }
)";

/// Escapes text for HTML. Invalid UTF-8 becomes U+FFFD.
std::string html(const std::string& text) {
  std::string safe;
  for (const char c : Json::parse(dump(text)).get<std::string>()) {
    switch (c) {
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '&':
        safe += "&amp;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

/// Thousands are separated; the column is sorted by the number itself.
std::string number_cell(const std::optional<std::uint64_t>& number, std::string_view css = "") {
  if (!number) return "<td data-v=\"-1\"></td>";
  std::string digits = fmt::format("{}", *number);
  for (std::size_t at = digits.size(); at > 3;) digits.insert(at -= 3, 1, ',');
  return fmt::format("<td{}{}{} data-v=\"{}\">{}</td>", css.empty() ? "" : " class=\"", css,
                     css.empty() ? "" : "\"", *number, digits);
}

std::string depth_cell(const std::optional<double>& depth) {
  if (!depth) return "<td data-v=\"-1\"></td>";
  return fmt::format("<td data-v=\"{}\">{:.3g}</td>", *depth, *depth);
}

/// Sort order: what needs attention comes first.
int rank_of(SweepState state) {
  switch (state) {
    case SweepState::Collides:
      return 0;
    case SweepState::Failed:
      return 1;
    case SweepState::Unclear:
      return 2;
    case SweepState::Clean:
      return 3;
    case SweepState::Still:
      break;
  }
  return 4;
}

void add_row(TextFile& file, const SweepRecord& r) {
  file.add("<tr><td>");
  if (!r.thumbnail.empty()) file.add("<img src=\"{}\" alt=\"\">", html(r.thumbnail));
  file.add("{}", html(r.path));
  if (!r.verdict.empty() && r.state == SweepState::Collides) file.add("<p>{}</p>", html(r.verdict));
  if (!r.repair.empty()) file.add("<p>Repair: {}</p>", html(r.repair));
  for (const std::string& note : r.notes)
    file.add("<details><summary>note</summary>{}</details>", html(note));
  if (!r.error.empty()) file.add("<details><summary>why</summary>{}</details>", html(r.error));
  file.add("</td><td class=\"{0}\" data-v=\"{1}\">{0}</td>", name_of(r.state), rank_of(r.state));
  file.add("{}{}", number_cell(r.contacts), depth_cell(r.depth));
  file.add("{}", number_cell(r.starts_crossing, r.starts_crossing.value_or(0) > 0 ? "starts" : ""));
  file.add("{}{}{}", number_cell(r.collisions), number_cell(r.steps_with_collisions), number_cell(r.steps));
  file.add("{}{}", number_cell(r.first_frame), number_cell(r.worst_frame));
  file.add("{}{}{}", number_cell(r.vertices), number_cell(r.triangles), number_cell(r.frames));
  file.add("<td data-v=\"{0}\">{0:.2f}</td><td>{1}</td></tr>\n", r.seconds, html(r.model));
}

void add_head(TextFile& file, std::span<const SweepRecord> records, const SweepScope& scope) {
  file.add("<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
  file.add("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
  file.add(
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'sha256-{}'; ",
      kScriptHash);
  file.add("style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'\">\n");
  std::string where;
  for (const std::string& directory : scope.directories) where += (where.empty() ? "" : ", ") + directory;
  file.add("<title>{0} - Foldproof sweep</title>\n<style>{1}</style>\n</head>\n<body>\n<h1>{0}</h1>\n",
           html(where), kStyle);
  std::array<std::size_t, 5> counts{};
  double seconds = 0;
  for (const SweepRecord& r : records) {
    ++counts.at(static_cast<std::size_t>(rank_of(r.state)));
    seconds += r.seconds;
  }
  file.add("<p><b>{} motions</b>: <span{}>{} collide</span>, ", records.size(),
           counts[0] > 0 ? " class=\"collides\"" : "", counts[0]);
  file.add("<span{}>{} failed</span>, ", counts[1] > 0 ? " class=\"failed\"" : "", counts[1]);
  if (counts[2] > 0) file.add("<span class=\"unclear\">{} unclear</span>, ", counts[2]);
  file.add("{} {}, {} of a single pose.</p>\n", counts[3],
           scope.steps_only ? "in whose steps no contact begins" : "clean", counts[4]);
  if (scope.steps_only)
    file.add("<p>Only the steps were checked: crossings from the first frame on were not tested.</p>\n");
  if (scope.poses) file.add("<p>Only the frames were checked: motion between them was not tested.</p>\n");
  if (!scope.frames.empty())
    file.add("<p>Only the frames {} of each motion were checked.</p>\n", html(scope.frames));
  if (const std::string cut = contacts_cut(records); !cut.empty()) file.add("<p>Contacts {}.</p>\n", cut);
  file.add("<details><summary>How this was made</summary><p>Foldproof {}, {} of checking.</p>", version(),
           duration(1000 * seconds));
  file.add("<p><code>{}</code></p></details>\n", html(scope.command));
}

}  // namespace

Result<void> write_sweep_page(const std::string& path, std::span<const SweepRecord> records,
                              const SweepScope& scope) {
  auto opened = FOLDPROOF_TRY(FileWriter::open(path));
  TextFile file(std::move(opened));
  add_head(file, records, scope);
  file.add(
      "<table>\n<thead><tr><th>motion</th><th>state</th><th>contacts</th><th>deepest</th><th>{1}</"
      "th><th>{2}</th><th>colliding {0}</th>",
      scope.poses ? "poses" : "steps", "crossing pairs of the first frame", "colliding pairs");
  file.add("<th>{}</th><th>first frame</th><th>worst frame</th><th>vertices</th>",
           scope.poses ? "poses" : "steps");
  file.add("<th>triangles</th><th>frames</th><th>seconds</th><th>model</th></tr></thead>\n<tbody>\n");
  std::vector<const SweepRecord*> sorted;
  for (const SweepRecord& record : records) sorted.push_back(&record);
  std::sort(sorted.begin(), sorted.end(), [](const SweepRecord* a, const SweepRecord* b) {
    if (a->state != b->state) return rank_of(a->state) < rank_of(b->state);
    if (a->depth != b->depth) return a->depth > b->depth;  // none is less than any
    if (a->collisions != b->collisions) return a->collisions > b->collisions;
    const auto start = [](const SweepRecord* r) { return r->starts_crossing.value_or(0); };
    return start(a) != start(b) ? start(a) > start(b) : a->path < b->path;
  });
  for (const SweepRecord* record : sorted) {
    add_row(file, *record);
    FOLDPROOF_TRY(file.flush_if_large());
  }
  file.add("</tbody>\n</table>\n<script>{}</script>\n</body>\n</html>\n", kScript);
  return file.commit();
}

}  // namespace foldproof
