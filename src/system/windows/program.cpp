#include "system/program.h"

#include <fcntl.h>
#include <io.h>
#include <windows.h>
// After it.
#include <shellapi.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <vector>

#include "text.h"

namespace foldproof::system {
namespace {

std::atomic<void (*)(int)> interrupt_handler = nullptr;

BOOL WINAPI call_handler(DWORD event) {
  interrupt_handler.load()(SIGINT);
  // The program ends when this returns, or after some seconds; until then it can still remove its files.
  if (event != CTRL_C_EVENT && event != CTRL_BREAK_EVENT) ::Sleep(INFINITE);
  return TRUE;
}

HANDLE console_of(std::FILE* stream) { return reinterpret_cast<HANDLE>(::_get_osfhandle(::_fileno(stream))); }

}  // namespace

std::span<char* const> start_program(int, char**) {
  for (std::FILE* stream : {stdin, stdout, stderr}) ::_setmode(::_fileno(stream), _O_BINARY);
  ::SetConsoleOutputCP(CP_UTF8);
  static std::vector<std::string> texts;
  static std::vector<char*> arguments;
  int count = 0;
  wchar_t** const wide_arguments = ::CommandLineToArgvW(::GetCommandLineW(), &count);
  for (int i = 0; i < count; ++i) texts.push_back(narrow(wide_arguments[i]));
  ::LocalFree(wide_arguments);
  for (std::string& text : texts) arguments.push_back(text.data());
  return arguments;
}

void on_interrupt(void (*handler)(int)) {
  interrupt_handler = handler;
  ::SetConsoleCtrlHandler(call_handler, TRUE);
}

std::thread thread_without_signals(std::function<void()> work) { return std::thread(std::move(work)); }

bool is_terminal(std::FILE* stream) {
  DWORD mode = 0;
  return ::GetConsoleMode(console_of(stream), &mode) != 0 &&
         ::SetConsoleMode(console_of(stream), mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING) != 0;
}

bool has_colors(std::FILE* stream) { return is_terminal(stream); }

// A pipe that its reader has closed is EINVAL here.
bool is_closed_pipe(int number) { return number == EPIPE || number == EINVAL; }

void open_browser(const std::string& address) {
  ::ShellExecuteW(nullptr, L"open", wide(address).c_str(), nullptr, nullptr, SW_SHOWNORMAL);
}

}  // namespace foldproof::system
