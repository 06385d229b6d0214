#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <sstream>

#include "commands.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kAbout =
    "Finds every collision of moving triangle meshes, with themselves and with each other, between frames "
    "too.";

/// CLI11's complaints may have several lines; a person gets one, with what to do.
Error command_line_error(const CLI::App& program, const CLI::ParseError& error) {
  std::string command = "foldproof";
  for (const CLI::App* chosen : program.get_subcommands()) command += " " + chosen->get_name();
  std::string problem = error.what();
  while (!problem.empty() && problem.back() == '\n') problem.pop_back();
  return {"command line", problem, fmt::format("'{} --help' shows what there is", command)};
}

/// Help without the notes on which options exclude which: they drown the descriptions.
struct HelpFormatter : CLI::Formatter {
  std::string make_option_opts(const CLI::Option* option) const override {
    return option->get_type_name().empty() ? "" : " " + option->get_type_name();
  }
};

Result<int> run(int argc, char** argv) {
  CLI::App program(kAbout);
  program.name("foldproof");
  const auto formatter = std::make_shared<HelpFormatter>();
  formatter->column_width(26);
  program.formatter(formatter);
  program.set_version_flag("--version", std::string("foldproof ") + version());
  program.require_subcommand(0, 1);  // that none is too few is said below, after unknown words were named
  program.footer(
      "Try:\n  foldproof check walk.glb\n  foldproof view walk.glb\n  foldproof check --help\n  foldproof "
      "train --help");
  const std::span<char* const> typed(argv, static_cast<std::size_t>(argc));
  const std::vector<std::pair<std::string, Command>> commands = {
      {"check", add_check(program)},          {"view", add_view(program)},
      {"report", add_report(program, typed)}, {"sweep", add_sweep(program, typed)},
      {"train", add_train(program)},          {"info", add_info(program)},
      {"predict", add_predict(program)},      {"suggest", add_suggest(program)},
      {"render", add_render(program)},        {"radius", add_radius(program)},
      {"reproduce", add_reproduce(program)}};

  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help or --version
    std::ostringstream text;
    program.exit(asked, text, text);
    print_output(text.str());
    return kExitClean;
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(command_line_error(program, error));
  }
  for (const auto& [name, command] : commands) {
    if (program.got_subcommand(name)) return command();
  }
  return fail("command line", "names no command", "'foldproof --help' shows what there is");
}

int finish(const Result<int>& result) {
  if (result) {
    if (const auto done = flush_output(); !done) return finish(tl::unexpected(done.error()));
    return *result;
  }
  print_error(result.error());
  return kExitError;
}

}  // namespace
}  // namespace foldproof

int main(int argc, char** argv) {
  // A reader that goes away, as in `foldproof check ... | head`, must not kill the check.
  std::signal(SIGPIPE, SIG_IGN);
  // Nor must a limit on file sizes, which would leave half a file: writing fails instead.
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return foldproof::finish(foldproof::run(argc, argv));
  } catch (const std::bad_alloc&) {
    return foldproof::finish(
        foldproof::fail("memory", "there is not enough", "check fewer objects or smaller meshes at a time"));
  } catch (const std::exception& error) {
    return foldproof::finish(
        foldproof::fail("foldproof", std::string("internal error: ") + error.what(), "please report this"));
  }
}
