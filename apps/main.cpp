#include <exception>

#include "base/try.h"
#include "commands.h"
#include "system/program.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kAbout =
    "Finds every collision of moving triangle meshes, with themselves and with each other, between frames "
    "too.";

constexpr const char* kProgramFooter =
    "Try:\n  foldproof check walk.glb\n  foldproof view walk.glb\n  foldproof help check\n  foldproof "
    "help train";

Result<int> run(std::span<char* const> arguments) {
  CommandLine program(kAbout, kProgramFooter);
  const std::vector<std::pair<std::string, Command>> commands = {{"check", add_check(program)},
                                                                 {"view", add_view(program, arguments)},
                                                                 {"repair", add_repair(program, arguments)},
                                                                 {"report", add_report(program, arguments)},
                                                                 {"sweep", add_sweep(program, arguments)},
                                                                 {"train", add_train(program)},
                                                                 {"info", add_info(program)},
                                                                 {"predict", add_predict(program)},
                                                                 {"render", add_render(program)},
                                                                 {"radius", add_radius(program)},
                                                                 {"sample", add_sample(program)},
                                                                 {"demo", add_demo(program)}};

  const auto text = FOLDPROOF_TRY(program.parse(arguments));
  if (text) {
    print_output(*text);
    return kExitClean;
  }
  for (const auto& [name, command] : commands) {
    if (program.chose(name)) return command();
  }
  // Nothing was checked: scripts must not read this as "no collisions".
  print_notice(program.help());
  return kExitError;
}

int finish(const Result<int>& result) {
  if (result) {
    if (const auto done = flush_output(); !done) return finish(tl::unexpected(done.error()));
    return *result;
  }
  print_error(result.error());
  return result.error().code == ErrorCode::Interrupted ? kExitInterrupted : kExitError;
}

}  // namespace
}  // namespace foldproof

int main(int argc, char** argv) {
  try {
    return foldproof::finish(foldproof::run(foldproof::system::start_program(argc, argv)));
  } catch (const std::bad_alloc&) {
    return foldproof::finish(foldproof::fail(foldproof::ErrorCode::LimitExceeded, "memory",
                                             "there is not enough",
                                             "check fewer objects or smaller meshes at a time"));
  } catch (const std::exception& error) {
    return foldproof::finish(foldproof::fail(foldproof::ErrorCode::InvalidArgument, "foldproof",
                                             std::string("internal error: ") + error.what(),
                                             "please report this"));
  }
}
