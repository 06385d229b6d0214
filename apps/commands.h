/// The program's subcommands, one file each.
#pragma once

#include <functional>
#include <span>

#include "command_line.h"

namespace foldproof {

/// Runs a subcommand after its arguments are parsed; gives its exit code or an error.
using Command = std::function<Result<int>()>;

/// Exit codes that scripts rely on.
inline constexpr int kExitClean = 0, kExitCollisions = 1, kExitError = 2, kExitInterrupted = 130;
/// The exit code of a complete check.
inline int exit_code(bool clean) { return clean ? kExitClean : kExitCollisions; }

/// Adds a subcommand to the command line; returns the function to run if it is chosen.
Command add_check(CommandLine& program);
Command add_train(CommandLine& program);
Command add_info(CommandLine& program);
Command add_predict(CommandLine& program);
Command add_render(CommandLine& program);
Command add_radius(CommandLine& program);
Command add_sample(CommandLine& program);
Command add_demo(CommandLine& program);
Command add_repair(CommandLine& program, std::span<char* const> arguments);
/// `program` must outlive the returned function.
Command add_view(CommandLine& program, std::span<char* const> arguments);
/// `arguments`: the command line, which reports quote.
Command add_report(CommandLine& program, std::span<char* const> arguments);
Command add_sweep(CommandLine& program, std::span<char* const> arguments);

}  // namespace foldproof
