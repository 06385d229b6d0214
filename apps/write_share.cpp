// A command for the build, which --help does not list.
#include <filesystem>

#include "base/try.h"
#include "commands.h"
#include "io/bytes.h"
#include "manual.h"

namespace foldproof {
namespace {

namespace fs = std::filesystem;

Result<void> write_file(const fs::path& path, const std::string& text) {
  std::error_code ignored;
  fs::create_directories(path.parent_path(), ignored);
  return io::write_file(path.string(), text);
}

Result<int> write_share(const fs::path& share, const std::vector<CommandDescription>& commands) {
  for (const CommandDescription& command : commands) {
    if (command.name == "help") continue;
    const std::string name = &command == &commands.front() ? "" : "-" + command.name;
    FOLDPROOF_TRY(
        write_file(share / "man/man1" / ("foldproof" + name + ".1"), manual_page(command, commands)));
  }
  FOLDPROOF_TRY(write_file(share / "bash-completion/completions/foldproof", bash_completion(commands)));
  // Debian's zsh reads the second below /usr, the first below /usr/local.
  for (const char* directory : {"zsh/site-functions", "zsh/vendor-completions"}) {
    FOLDPROOF_TRY(write_file(share / directory / "_foldproof", zsh_completion(commands)));
  }
  FOLDPROOF_TRY(write_file(share / "fish/vendor_completions.d/foldproof.fish", fish_completion(commands)));
  return kExitClean;
}

}  // namespace

Command add_write_share(CommandLine& program) {
  const Subcommand command = program.add_subcommand("write-share", "Write manual pages and completions");
  command.hide();
  const auto directory = std::make_shared<std::string>();
  command.add_option("DIR", *directory, "What is installed as share").type_name("").required();
  return [directory, &program] { return write_share(*directory, program.describe()); };
}

}  // namespace foldproof
