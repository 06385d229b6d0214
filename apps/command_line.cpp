#include "command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "base/nearest_name.h"

namespace foldproof {
namespace {

constexpr const char* kHelp = "help";
/// Between what is wrong with a value and what to do about it.
constexpr std::string_view kRemedy = "; ";

std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  if (names.empty()) names.push_back(option.get_name() + (option.get_items_expected_max() > 1 ? "..." : ""));
  return names;
}

const CLI::App& chosen_command(const CLI::App& program) {
  const auto chosen = program.get_subcommands();
  return chosen.empty() ? program : *chosen.front();
}

/// What an unknown word was meant to be, as a remedy; empty: nothing is like it.
std::string meant_by(const CLI::App& command, const std::string& word) {
  std::vector<std::string> known;
  const bool is_option = word.starts_with('-');
  for (const CLI::Option* option : command.get_options()) {
    if (!is_option) break;
    const auto names = names_of(*option);
    known.insert(known.end(), names.begin(), names.end());
  }
  if (!is_option) {
    for (const CLI::App* other : command.get_subcommands([](const CLI::App*) { return true; }))
      known.push_back(other->get_name());
  }
  const auto name = nearest_name(word.substr(0, word.find('=')), known);
  if (name) return fmt::format("did you mean '{}'?", *name);
  std::error_code ignored;
  if (!is_option && command.get_parent() == nullptr && std::filesystem::exists(word, ignored))
    return fmt::format("did you mean 'foldproof check {}'?", word);
  return "";
}

Error command_line_error(const CLI::App& command, std::string problem, std::string remedy = "") {
  const std::string name = command.get_parent() ? "foldproof " + command.get_name() : "foldproof";
  if (remedy.empty()) remedy = fmt::format("'{} --help' shows what there is", name);
  return {"command line", std::move(problem), std::move(remedy), ErrorCode::InvalidArgument};
}

Error unknown_word(const CLI::App& command, const std::string& word) {
  const std::string of = command.get_parent() ? " of foldproof " + command.get_name() : " of foldproof";
  std::string problem = fmt::format("'{}' is no command{}", word, of);
  if (command.get_parent()) problem = fmt::format("'{}' is one argument too many", word);
  if (word.starts_with('-')) problem = fmt::format("'{}' is no option{}", word, of);
  return command_line_error(command, problem, meant_by(command, word));
}

/// An error of CLI11, which may have several lines.
Error parse_error(const CLI::App& program, const CLI::ParseError& error) {
  const CLI::App& command = chosen_command(program);
  const auto unknown = program.remaining(true);
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError) && !unknown.empty())
    return unknown_word(command, unknown.front());
  std::string problem = error.what();
  while (!problem.empty() && problem.back() == '\n') problem.pop_back();
  const std::size_t end = problem.find(kRemedy);
  if (end == std::string::npos) return command_line_error(command, problem);
  return command_line_error(command, problem.substr(0, end), problem.substr(end + kRemedy.size()));
}

/// What `help` and these words print.
Result<std::string> help_of(const CLI::App& program, std::span<const std::string> words) {
  if (words.empty()) return program.help();
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == words.front()) return command->help(program.get_name());
  }
  return tl::unexpected(unknown_word(program, words.front()));
}

/// Of numbers that are out of range CLI11 takes one that is in it.
template <class T>
std::string range_problem(const std::string& text) {
  errno = 0;
  if constexpr (std::is_signed_v<T>) {
    std::strtoll(text.c_str(), nullptr, 0);
  } else {
    if (text.starts_with('-')) return text + " is below 0";
    std::strtoull(text.c_str(), nullptr, 0);
  }
  return errno == ERANGE ? text + " is out of range" : "";
}

template <class T>
std::string number_problem(const std::string& text) {
  T number{};
  if (CLI::detail::lexical_cast(text, number)) return "";
  return fmt::format("'{}' is not a {}number{}give one", text, std::is_integral_v<T> ? "whole " : "",
                     kRemedy);
}

std::string choice_problem(const std::string& text, const std::vector<std::string>& values) {
  if (std::ranges::find(values, text) != values.end()) return "";
  const auto near = nearest_name(text, values);
  return fmt::format(
      "'{}' is not known{}{}", text, kRemedy,
      near ? fmt::format("did you mean '{}'?", *near) : fmt::format("give {}", fmt::join(values, " or ")));
}

/// Omits the notes on which options exclude each other, which obscure the descriptions.
struct HelpFormatter : CLI::Formatter {
  std::string make_option_opts(const CLI::Option* option) const override {
    return option->get_type_name().empty() ? "" : " " + option->get_type_name();
  }
};

}  // namespace

Option Option::type_name(const std::string& name) const { return Option(option_->type_name(name)); }
Option Option::group(const std::string& heading) const { return Option(option_->group(heading)); }
std::string Option::group() const { return option_->get_group(); }
Option Option::description(const std::string& text) const { return Option(option_->description(text)); }
Option Option::required() const { return Option(option_->required()); }
bool Option::is_required() const { return option_->get_required(); }
Option Option::excludes(Option other) const { return Option(option_->excludes(other.option_)); }
Option Option::one_of(const std::vector<std::string>& values) const {
  return Option(option_->check([values](const std::string& text) { return choice_problem(text, values); })
                    ->type_name(fmt::format("{}", fmt::join(values, "|"))));
}
Option Option::between(double least, double most) const {
  return Option(option_->check(CLI::Range(least, most).description("")));
}
Option Option::expected(int least, int most) const { return Option(option_->expected(least, most)); }
Option Option::one_value_each_time() const { return Option(option_->allow_extra_args(false)); }
std::string Option::name() const {
  return option_->get_snames().empty() ? option_->get_name() : "-" + option_->get_snames()[0];
}
std::vector<std::string> Option::values() const { return option_->results(); }

template <class T>
Option Subcommand::add_option(const std::string& names, T& value, const std::string& description) const {
  CLI::Option* option = app_->add_option(names, value, description);
  if constexpr (std::is_integral_v<T>) option->check(range_problem<T>)->check(number_problem<T>);
  if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::optional<double>>)
    option->check(number_problem<double>);
  // Of a pair of which one is missing, CLI11 takes the next option.
  if constexpr (std::is_same_v<T, std::vector<std::pair<std::string, std::string>>>)
    option->check([app = app_](const std::string& text) {
      return app->get_option_no_throw(text) == nullptr
                 ? ""
                 : fmt::format("'{}' is an option{}give two names", text, kRemedy);
    });
  return Option(option);
}
template Option Subcommand::add_option(const std::string&, std::string&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::vector<std::string>&,
                                       const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::vector<std::pair<std::string, std::string>>&,
                                       const std::string&) const;
template Option Subcommand::add_option(const std::string&, double&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, int&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::optional<double>&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::int64_t&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::uint16_t&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::uint32_t&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::uint64_t&, const std::string&) const;

Option Subcommand::add_flag(const std::string& names, bool& value, const std::string& description) const {
  return Option(app_->add_flag(names, value, description));
}
Option Subcommand::add_flag(const std::string& names, const std::function<void()>& set,
                            const std::string& description) const {
  return Option(app_->add_flag_callback(names, set, description));
}
Option Subcommand::option(const char* name) const { return Option(app_->get_option(name)); }
void Subcommand::exclude_all_but(Option option, std::span<const char* const> names) const {
  for (CLI::Option* other : app_->get_options()) {
    const bool goes = std::ranges::any_of(names, [&](const char* name) { return other->check_name(name); });
    if (!goes && other != option.option_) option.option_->excludes(other);
  }
}
void Subcommand::footer(const std::string& text) const { app_->footer(text); }

CommandLine::CommandLine(const std::string& about, const std::string& footer)
    : app_(std::make_unique<CLI::App>(about)) {
  app_->name("foldproof");
  const auto formatter = std::make_shared<HelpFormatter>();
  formatter->column_width(26);
  app_->formatter(formatter);
  app_->set_version_flag("-V,--version", std::string("foldproof ") + version() + "\n" + build_info(),
                         "Print the version, and how it was built, and exit");
  app_->set_help_flag("-h,--help", "Print this help, and exit");
  app_->allow_windows_style_options(false);  // a slash begins a path
  app_->require_subcommand(0, 1);  // none is the caller's error, so that unknown words are reported first
  app_->footer(footer);
  app_->add_subcommand(kHelp, "Show the options of a command, with examples: help COMMAND");
}
CommandLine::~CommandLine() = default;

Subcommand CommandLine::add_subcommand(const std::string& name, const std::string& description) {
  return Subcommand(app_->add_subcommand(name, description));
}

Result<std::optional<std::string>> CommandLine::parse(std::span<char* const> arguments) {
  std::vector<std::string> words;
  for (const char* word : arguments.subspan(std::min<std::size_t>(1, arguments.size())))
    words.push_back(word);
  if (!words.empty() && words.front() == kHelp) return help_of(*app_, std::span(words).subspan(1));
  std::reverse(words.begin(), words.end());  // as CLI11 takes them
  try {
    app_->parse(std::move(words));
  } catch (const CLI::Success& help) {  // --help or --version
    std::ostringstream text;
    app_->exit(help, text, text);
    return text.str();
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(parse_error(*app_, error));
  }
  return std::nullopt;
}

std::string CommandLine::help() const { return app_->help(); }

bool CommandLine::chose(const std::string& subcommand) const { return app_->got_subcommand(subcommand); }

}  // namespace foldproof
