/// The program's subcommands, one file each.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "foldproof/base.h"

namespace foldproof {

/// What a subcommand does once its arguments are read: its exit code, or why it could not.
using Command = std::function<Result<int>()>;

/// Exit codes that scripts rely on.
inline constexpr int kExitClean = 0, kExitCollisions = 1, kExitError = 2, kExitInterrupted = 130;
/// Of a check that came to its end.
inline int exit_code(bool clean) { return clean ? kExitClean : kExitCollisions; }

/// Adds a subcommand to the command line; gives what to run if it is chosen.
Command add_check(CLI::App& program);
Command add_train(CLI::App& program);
Command add_info(CLI::App& program);
Command add_predict(CLI::App& program);
Command add_suggest(CLI::App& program);
Command add_render(CLI::App& program);
Command add_reproduce(CLI::App& program);
Command add_radius(CLI::App& program);
Command add_view(CLI::App& program);
/// `typed`: the command line, which reports repeat.
Command add_report(CLI::App& program, std::span<char* const> typed);
Command add_sweep(CLI::App& program, std::span<char* const> typed);

}  // namespace foldproof
