/// Manual pages and completion for shells, from the command line's definitions.
#pragma once

#include "command_line.h"

namespace foldproof {

/// The page of a command for man(1), in roff. `commands`: all, the program first.
std::string manual_page(const CommandDescription& command, const std::vector<CommandDescription>& commands);

/// Scripts that complete commands, options and their values; of files, their names.
std::string bash_completion(const std::vector<CommandDescription>& commands);
std::string zsh_completion(const std::vector<CommandDescription>& commands);
std::string fish_completion(const std::vector<CommandDescription>& commands);

}  // namespace foldproof
