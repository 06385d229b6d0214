#include "command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <sstream>

namespace foldproof {
namespace {

/// Converts an error of CLI11, which may have several lines, to one line with a remedy.
Error command_line_error(const CLI::App& program, const CLI::ParseError& error) {
  std::string command = "foldproof";
  for (const CLI::App* chosen : program.get_subcommands()) command += " " + chosen->get_name();
  std::string problem = error.what();
  while (!problem.empty() && problem.back() == '\n') problem.pop_back();
  return {"command line", problem, fmt::format("'{} --help' shows what there is", command),
          ErrorCode::InvalidArgument};
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
  return Option(option_->check(CLI::IsMember(values)));
}
Option Option::between(double least, double most) const {
  return Option(option_->check(CLI::Range(least, most)));
}
Option Option::expected(int least, int most) const { return Option(option_->expected(least, most)); }
Option Option::one_value_each_time() const { return Option(option_->allow_extra_args(false)); }
std::string Option::name() const {
  return option_->get_snames().empty() ? option_->get_name() : "-" + option_->get_snames()[0];
}
std::vector<std::string> Option::values() const { return option_->results(); }

template <class T>
Option Subcommand::add_option(const std::string& names, T& value, const std::string& description) const {
  return Option(app_->add_option(names, value, description));
}
template Option Subcommand::add_option(const std::string&, std::string&, const std::string&) const;
template Option Subcommand::add_option(const std::string&, std::vector<std::string>&,
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
Option Subcommand::option(const char* name) const { return Option(app_->get_option(name)); }
void Subcommand::footer(const std::string& text) const { app_->footer(text); }

CommandLine::CommandLine(const std::string& about, const std::string& footer)
    : app_(std::make_unique<CLI::App>(about)) {
  app_->name("foldproof");
  const auto formatter = std::make_shared<HelpFormatter>();
  formatter->column_width(26);
  app_->formatter(formatter);
  app_->set_version_flag("--version", std::string("foldproof ") + version());
  app_->require_subcommand(0, 1);  // none is the caller's error, so that unknown words are reported first
  app_->footer(footer);
}
CommandLine::~CommandLine() = default;

Subcommand CommandLine::add_subcommand(const std::string& name, const std::string& description) {
  return Subcommand(app_->add_subcommand(name, description));
}

Result<std::optional<std::string>> CommandLine::parse(std::span<char* const> arguments) {
  try {
    app_->parse(static_cast<int>(arguments.size()), arguments.data());
  } catch (const CLI::Success& help) {  // --help or --version
    std::ostringstream text;
    app_->exit(help, text, text);
    return text.str();
  } catch (const CLI::ParseError& error) {
    return tl::unexpected(command_line_error(*app_, error));
  }
  return std::nullopt;
}

bool CommandLine::chose(const std::string& subcommand) const { return app_->got_subcommand(subcommand); }

}  // namespace foldproof
