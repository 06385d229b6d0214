/// What a program and its terminal have to do with each other. The bodies are in posix/ and windows/.
#pragma once

#include <cstdio>
#include <functional>
#include <span>
#include <string>
#include <thread>

namespace foldproof::system {

/// Call it first in main. From then on a closed pipe, or a file that would become too large, is an error of
/// who writes it, not the end of the program; what is printed is UTF-8, without other ends of lines. Returns
/// the arguments, as UTF-8; valid until the program ends.
std::span<char* const> start_program(int argc, char** argv);

/// From now on Ctrl-C, a request to end, and a terminal that is closed call `handler`, which may do what
/// handlers of signals may.
void on_interrupt(void (*handler)(int));

/// A thread that no signal interrupts.
std::thread thread_without_signals(std::function<void()> work);

/// Whether a stream is a terminal that knows escape sequences.
bool is_terminal(std::FILE* stream);

/// Whether it is one that has colors.
bool has_colors(std::FILE* stream);

/// Whether an errno of printing says that nobody reads it any more.
bool is_closed_pipe(int number);

/// Opens a page if there is a display; else does nothing.
void open_browser(const std::string& address);

}  // namespace foldproof::system
