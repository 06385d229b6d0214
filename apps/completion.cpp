#include <fmt/format.h>

#include <algorithm>

#include "manual.h"
#include "options.h"

namespace foldproof {
namespace {

/// The values of "proven|paper".
std::vector<std::string> choices(const OptionDescription& option) {
  std::vector<std::string> values;
  if (option.value.find('|') == std::string::npos) return values;
  for (std::size_t begin = 0; begin <= option.value.size();) {
    const std::size_t end = std::min(option.value.find('|', begin), option.value.size());
    values.push_back(option.value.substr(begin, end - begin));
    begin = end + 1;
  }
  return values;
}

std::vector<std::string> option_names(const CommandDescription& command) {
  std::vector<std::string> names;
  for (const OptionDescription& option : command.options) {
    if (!option.is_argument) names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return names;
}

std::vector<std::string> command_names(const std::vector<CommandDescription>& commands) {
  std::vector<std::string> names;
  for (std::size_t k = 1; k < commands.size(); ++k) names.push_back(commands[k].name);
  return names;
}

/// Puts a backslash before each of these characters.
std::string escaped(const std::string& text, std::string_view characters) {
  std::string out;
  for (const char c : text) {
    if (characters.find(c) != characters.npos) out += '\\';
    out += c;
  }
  return out;
}

}  // namespace

std::string bash_completion(const std::vector<CommandDescription>& commands) {
  std::string cases;
  for (std::size_t k = 1; k < commands.size(); ++k) {
    const bool is_help = commands[k].name == "help";
    cases += fmt::format("    {})\n      words='{}'\n      case $previous in\n", commands[k].name,
                         fmt::join(is_help ? command_names(commands) : option_names(commands[k]), " "));
    for (const OptionDescription& option : commands[k].options) {
      const auto values = choices(option);
      if (!values.empty())
        cases += fmt::format("        {}) words='{}' chosen=yes ;;\n", fmt::join(option.names, "|"),
                             fmt::join(values, " "));
    }
    cases += fmt::format("      esac\n{}      ;;\n", is_help ? "      chosen=yes\n" : "");
  }
  return fmt::format(R"(# Completion of foldproof for bash.
_foldproof() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}} words='' chosen=''
  case ${{COMP_WORDS[1]}} in
{}  esac
  if ((COMP_CWORD == 1)); then
    words='{} {}' chosen=yes
  fi
  COMPREPLY=()
  # Else the name of a file.
  if [[ -n $chosen || $word == -* ]]; then
    COMPREPLY=($(compgen -W "$words" -- "$word"))
  fi
}}
complete -o default -F _foldproof foldproof
)",
                     cases, fmt::join(command_names(commands), " "),
                     fmt::join(option_names(commands[0]), " "));
}

std::string zsh_completion(const std::vector<CommandDescription>& commands) {
  std::string names, cases;
  for (std::size_t k = 1; k < commands.size(); ++k) {
    names += "    " + in_quotes(escaped(commands[k].name, ":") + ":" + commands[k].description) + "\n";
    cases += fmt::format("    {})\n      _arguments", commands[k].name);
    for (const OptionDescription& option : commands[k].options) {
      const auto values = choices(option);
      std::string value = option.value.empty() ? "" : fmt::format(":{}:_files", escaped(option.value, ":"));
      if (!values.empty()) value = fmt::format(":value:({})", fmt::join(values, " "));
      for (const std::string& name : option.names) {
        if (!option.is_argument)
          cases += " \\\n        " +
                   in_quotes(fmt::format("*{}[{}]{}", name, escaped(option.description, "[]:\\"), value));
      }
    }
    const std::string rest =
        commands[k].name == "help" ? fmt::format("({})", fmt::join(command_names(commands), " ")) : "_files";
    cases += " \\\n        " + in_quotes("*:file:" + rest) + "\n      ;;\n";
  }
  return fmt::format(R"(#compdef foldproof
# Completion of foldproof for zsh.
_foldproof() {{
  local -a commands=(
{})
  if ((CURRENT == 2)); then
    _describe command commands
    return
  fi
  shift words
  ((CURRENT--))
  case $words[1] in
{}  esac
}}
_foldproof "$@"
)",
                     names, cases);
}

std::string fish_completion(const std::vector<CommandDescription>& commands) {
  const auto quoted_fish = [](const std::string& text) { return "'" + escaped(text, "'\\") + "'"; };
  std::string out = "# Completion of foldproof for fish.\n";
  const auto add_options = [&](const CommandDescription& command, const std::string& condition) {
    for (const OptionDescription& option : command.options) {
      if (option.is_argument) continue;
      out += fmt::format("complete -c foldproof -n {}", quoted_fish(condition));
      for (const std::string& name : option.names)
        out += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      const auto values = choices(option);
      if (!values.empty()) {
        out += fmt::format(" -x -a '{}'", fmt::join(values, " "));
      } else if (!option.value.empty()) {
        out += " -r";
      }
      out += " -d " + quoted_fish(option.description) + "\n";
    }
  };
  add_options(commands[0], "__fish_use_subcommand");
  for (std::size_t k = 1; k < commands.size(); ++k) {
    const CommandDescription& command = commands[k];
    out += fmt::format("complete -c foldproof -n __fish_use_subcommand -f -a {} -d {}\n", command.name,
                       quoted_fish(command.description));
    const std::string seen = "__fish_seen_subcommand_from " + command.name;
    add_options(command, seen);
    if (command.name == "help")
      out += fmt::format("complete -c foldproof -n '{}' -f -a '{}'\n", seen,
                         fmt::join(command_names(commands), " "));
  }
  return out;
}

}  // namespace foldproof
