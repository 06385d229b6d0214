/// The command line's subcommands and options. Only command_line.cpp includes CLI11, which takes longer to
/// compile than most of what uses it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "foldproof/base.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace foldproof {

/// An option, or an argument without a name, of a subcommand. Copies denote the same one; the CommandLine
/// owns it.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  /// What stands for the value in the help text: FILE, N.
  Option type_name(const std::string& name) const;
  /// The heading in the help text that it stands below.
  Option group(const std::string& heading) const;
  std::string group() const;
  Option description(const std::string& text) const;

  Option required() const;
  bool is_required() const;
  Option excludes(Option other) const;
  /// Accepts only these values, which also stand for the value in the help: "proven|paper".
  Option one_of(const std::vector<std::string>& values) const;
  /// Accepts only numbers from `least` to `most`.
  Option between(double least, double most) const;
  /// Takes from `least` to `most` values.
  Option expected(int least, int most) const;
  /// Takes one value each time that it is given; more values need the option again.
  Option one_value_each_time() const;

  /// "-o", "--json", "MOTION": as a person would type it.
  std::string name() const;
  /// What the command line gave, in order.
  std::vector<std::string> values() const;

 private:
  friend class Subcommand;
  CLI::Option* option_;
};

/// A subcommand. Copies denote the same one; the CommandLine owns it.
class Subcommand {
 public:
  explicit Subcommand(CLI::App* app) : app_(app) {}

  /// Adds an option that sets `value`. Names that do not begin with '-' are arguments, in order. T: see the
  /// instantiations in command_line.cpp.
  template <class T>
  Option add_option(const std::string& names, T& value, const std::string& description) const;
  /// Adds an option without a value that sets `value` to true.
  Option add_flag(const std::string& names, bool& value, const std::string& description) const;
  /// The same, and `set` is called where it is given.
  Option add_flag(const std::string& names, const std::function<void()>& set,
                  const std::string& description) const;
  /// One that was added.
  Option option(const char* name) const;
  /// From now on `option` goes with none of those that were added, except these.
  void exclude_all_but(Option option, std::span<const char* const> names) const;
  /// What the help text ends with.
  void footer(const std::string& text) const;

 private:
  CLI::App* app_;
};

class CommandLine {
 public:
  CommandLine(const std::string& about, const std::string& footer);
  ~CommandLine();

  Subcommand add_subcommand(const std::string& name, const std::string& description);

  /// A text to print, if --help, help or --version asks for one, or else nothing. Error: what does not parse.
  Result<std::optional<std::string>> parse(std::span<char* const> arguments);
  /// What --help prints.
  std::string help() const;
  /// Whether the parsed command line names this subcommand.
  bool chose(const std::string& subcommand) const;

 private:
  std::unique_ptr<CLI::App> app_;
};

}  // namespace foldproof
