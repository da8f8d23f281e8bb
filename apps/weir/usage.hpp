// Helps with the command line: errors with suggestions, help of a command, and what a shell can
// complete.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <CLI/CLI.hpp>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace weir::app {

// The hidden command of completions/weir, the file for bash.
inline constexpr char kCompleteCommand[] = "complete";

// A check whose error says what is needed: "'abc' is not a number from 0.001 to 1000000".
template <typename Number>
CLI::Validator in_range(Number min, Number max) {
  const auto check = [min, max](const std::string& text) -> std::string {
    Number value{};
    if (CLI::detail::lexical_cast(text, value) && value >= min && value <= max) return "";
    std::ostringstream out;
    out.precision(9);
    out << '\'' << text << "' is not a number from " << min << " to " << max;
    return out.str();
  };
  return CLI::Validator(check, "");
}

// Formats help without the texts that CLI11 adds for checks and options that exclude each other.
std::shared_ptr<CLI::FormatterBase> help_formatter();

// Prints to stderr what is wrong with a command line that `app` could not parse, and the nearest
// command or option. Returns kExitUsage.
int report_usage_error(const CLI::App& app, const CLI::ParseError& error);

// Prints the help of the command that the names lead to: {"pki", "issue"}; none: of `app`.
// kExitUsage when there is no such command.
int show_help(const CLI::App& app, const std::vector<std::string>& topic);

// Prints the commands or options that the last of `words`, which follow "weir", can become, one on
// each line. Nothing where a file or a value is expected.
int print_completions(const CLI::App& app, const std::vector<std::string>& words);

}  // namespace weir::app
