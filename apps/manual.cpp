#include "manual.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

namespace foldproof {
namespace {

/// Text as roff shows it.
std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '\\':
        out += "\\e";
        break;
      case '-':
        out += "\\-";
        break;
      case '^':
        out += "\\(ha";
        break;
      case '~':
        out += "\\(ti";
        break;
      case '`':
        out += "\\(ga";
        break;
      default:
        out += c;
    }
  }
  return out;
}

/// A line of text. No request: those begin with a period or an apostrophe.
std::string line(std::string_view text) {
  return (text.starts_with('.') || text.starts_with('\'') ? "\\&" : "") + escaped(text) + "\n";
}

std::string bold(std::string_view text) { return "\\fB" + escaped(text) + "\\fR"; }
std::string italic(std::string_view text) { return "\\fI" + escaped(text) + "\\fR"; }

std::string title(const CommandDescription& command) {
  return command.name == "foldproof" ? command.name : "foldproof-" + command.name;
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string synopsis(const CommandDescription& command, bool has_commands) {
  std::string text = command.name == "foldproof" ? bold("foldproof") : bold("foldproof " + command.name);
  text += " [" + italic("OPTION") + "]...";
  if (has_commands) text += " " + italic("COMMAND") + " ...";
  for (const OptionDescription& option : command.options) {
    if (option.is_argument)
      text += " " +
              (option.is_required ? italic(option.names.front()) : "[" + italic(option.names.front()) + "]");
  }
  return text + "\n";
}

std::string option_paragraph(const OptionDescription& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.names) names.push_back(bold(name));
  const std::string value = option.is_argument || option.value.empty() ? "" : " " + italic(option.value);
  return fmt::format(".TP\n{}{}\n{}", fmt::join(names, ", "), value, line(option.description));
}

/// By group, in the order in which groups begin.
std::string options(const CommandDescription& command) {
  std::vector<std::pair<std::string, std::string>> groups;
  for (const OptionDescription& option : command.options) {
    const std::string heading = option.is_argument ? "Arguments" : option.group;
    auto group = std::ranges::find(groups, heading, &std::pair<std::string, std::string>::first);
    if (group == groups.end()) group = groups.insert(group, {heading, ""});
    group->second += option_paragraph(option);
  }
  std::string text;
  for (const auto& [heading, paragraphs] : groups) text += ".SS " + escaped(heading) + "\n" + paragraphs;
  return text;
}

bool is_examples(const std::string& heading) { return heading == "Examples:" || heading == "Try:"; }

/// The footer of a help text. Its indented lines are terms, two spaces or more, and what is said of them,
/// which deeper lines continue.
std::string footer(const std::string& text) {
  constexpr std::size_t kContinuation = 8;
  std::istringstream lines(text);
  std::string out = is_examples(text.substr(0, text.find('\n'))) ? "" : ".SH DESCRIPTION\n";
  bool is_after_terms = false;
  for (std::string all; std::getline(lines, all);) {
    const std::size_t indent = all.find_first_not_of(' ');
    if (indent == all.npos) {
      out += ".PP\n";
    } else if (is_examples(all)) {
      out += ".SH EXAMPLES\n";
    } else if (all.starts_with("Exit code: ")) {
      out += ".SH EXIT STATUS\n" + line(all.substr(all.find(':') + 2));
    } else if (indent == 0 || indent >= kContinuation) {
      if (indent == 0 && is_after_terms) out += ".PP\n";
      out += line(std::string_view(all).substr(indent));
    } else {
      const std::size_t gap = all.rfind("  ");
      const std::string term =
          all.substr(indent, gap > indent ? all.find_last_not_of(' ', gap) + 1 - indent : all.npos);
      out += ".TP\n" + bold(term) + "\n";
      if (gap > indent) out += line(std::string_view(all).substr(gap + 2));
    }
    is_after_terms = indent != all.npos && indent > 0;
  }
  return out;
}

}  // namespace

std::string manual_page(const CommandDescription& command, const std::vector<CommandDescription>& commands) {
  const bool is_program = &command == &commands.front();
  std::string text = fmt::format(".TH {} 1 \"\" \"foldproof {}\" Foldproof\n.nh\n.ad l\n.SH NAME\n{} \\- {}",
                                 upper(escaped(title(command))), version(), escaped(title(command)),
                                 line(command.description));
  text += ".SH SYNOPSIS\n" + synopsis(command, is_program);
  if (is_program) {
    text += ".SH COMMANDS\n";
    for (std::size_t k = 1; k < commands.size(); ++k)
      text += fmt::format(".TP\n{}\n{}", bold(commands[k].name), line(commands[k].description));
  }
  text += ".SH OPTIONS\n" + options(command) + footer(command.footer) + ".SH SEE ALSO\n";
  std::vector<std::string> others;
  for (const CommandDescription& other : commands) {
    if (&other != &command && other.name != "help")
      others.push_back(fmt::format("{}(1)", bold(title(other))));
  }
  return text + fmt::format("{}\n", fmt::join(others, ", "));
}

}  // namespace foldproof
