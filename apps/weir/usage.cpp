// Helps with the command line: errors with suggestions, help of a command, and what a shell can
// complete.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "usage.hpp"

#include <cstdio>

#include "commands.hpp"
#include "core/text/text.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

// "weir pki issue".
std::string full_name(const CLI::App& app) {
  return app.get_parent() ? full_name(*app.get_parent()) + " " + app.get_name() : app.get_name();
}

std::string help_command(const CLI::App& app) {
  std::string out = full_name(app);
  return out.insert(out.find(' ') == std::string::npos ? out.size() : out.find(' '), " help");
}

// The commands of `app` that its help shows.
std::vector<std::string> names_of_commands(const CLI::App& app) {
  std::vector<std::string> out;
  for (const CLI::App* command :
       app.get_subcommands([](const CLI::App* each) { return !each->get_group().empty(); }))
    out.push_back(command->get_name());
  return out;
}

std::vector<std::string> names_of_options(const CLI::App& app) {
  std::vector<std::string> out;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) out.push_back("--" + name);
  return out;
}

std::string suggestion(const std::string& typed, const std::vector<std::string>& known) {
  const std::string close = nearest(typed, known);
  return close.empty() ? "" : " Did you mean '" + close + "'?";
}

int report_unknown_command(const CLI::App& app, const std::string& typed) {
  std::fprintf(stderr, "%s has no command '%s'.%s\n%s lists the commands.\n",
               full_name(app).c_str(), typed.c_str(),
               suggestion(typed, names_of_commands(app)).c_str(), help_command(app).c_str());
  return kExitUsage;
}

class HelpFormatter : public CLI::Formatter {
 public:
  // "--metrics[=ADDRESS]" for a flag that takes a value, where CLI11 prints its default in braces.
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override {
    std::string out = Formatter::make_option_name(option, is_positional);
    if (const size_t brace = out.find('{'); brace != std::string::npos)
      out.replace(brace, std::string::npos, "[=ADDRESS]");
    return out;
  }

  std::string make_option_opts(const CLI::Option* option) const override {
    if (option->get_type_size() == 0) return "";
    const std::string type = option->get_type_name();
    std::string out = " " + type.substr(0, type.find(':'));
    if (option->get_expected_max() == CLI::detail::expected_max_vector_size) out += " ...";
    if (option->get_required()) out += " REQUIRED";
    return out;
  }
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> help_formatter() {
  return std::make_shared<HelpFormatter>();
}

int report_usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  const auto commands = names_of_commands(*command);
  const auto rest = command->remaining();
  const bool has_option = !rest.empty() && rest.front().starts_with("-");
  if (!commands.empty() && !rest.empty() && !has_option)
    return report_unknown_command(*command, rest.front());
  const std::string name = full_name(*command), help = help_command(*command);
  if (has_option)
    std::fprintf(stderr, "%s has no option '%s'.%s\n%s shows the options.\n", name.c_str(),
                 rest.front().c_str(), suggestion(rest.front(), names_of_options(*command)).c_str(),
                 help.c_str());
  else if (!commands.empty())
    std::fprintf(stderr, "%s needs a command: %s\n%s shows them.\n", name.c_str(),
                 join(commands, ", ").c_str(), help.c_str());
  else
    std::fprintf(stderr, "%s: %s\n%s shows the options.\n", name.c_str(), error.what(),
                 help.c_str());
  return kExitUsage;
}

int show_help(const CLI::App& app, const std::vector<std::string>& topic) {
  const CLI::App* command = &app;
  for (const std::string& name : topic) {
    const auto found =
        command->get_subcommands([&name](const CLI::App* each) { return each->check_name(name); });
    if (found.empty()) return report_unknown_command(*command, name);
    command = found.front();
  }
  // Not command->help(), which shows that of the command on the command line: "help".
  std::fputs(command->get_formatter()
                 ->make_help(command, full_name(*command), CLI::AppFormatMode::Normal)
                 .c_str(),
             stdout);
  return kExitGood;
}

int print_completions(const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* command = &app;
  for (size_t i = 0; i + 1 < words.size(); ++i) {
    if (words[i] == "help") continue;  // its arguments are commands
    const auto found =
        command->get_subcommands([&](const CLI::App* each) { return each->check_name(words[i]); });
    if (!found.empty()) command = found.front();
  }
  const std::string typed = words.empty() ? "" : words.back();
  const std::vector<std::string> known =
      typed.starts_with("-") ? names_of_options(*command) : names_of_commands(*command);
  for (const std::string& name : known)
    if (name.starts_with(typed)) std::puts(name.c_str());
  return kExitGood;
}

}  // namespace weir::app
