// SPDX-License-Identifier: LGPL-2.1-or-later
#include "report.hpp"

#include <algorithm>
#include <cstdio>

#include "colour.hpp"
#include "commands.hpp"
#include "weir/printable_text.hpp"

namespace weir::app {
namespace {

bool is_number(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789.-") == std::string::npos;
}

bool is_control(char c) {
  return static_cast<unsigned char>(c) < ' ' || c == '\x7f';
}

// Counts characters, not bytes, to align names in any script.
size_t count_characters(const std::string& text) {
  return static_cast<size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

// JSON text with the control characters that JSON permits in strings as \uNNNN.
std::string for_terminal(std::string_view json) {
  std::string out;
  while (!json.empty()) {
    const size_t length = std::max<size_t>(utf8_sequence(json), 1);
    const auto character = json.substr(0, length);
    if (character != "\n" && is_terminal_control(character))
      append_json_escape(character, &out);
    else
      out += character;
    json.remove_prefix(length);
  }
  return out;
}

struct Columns {
  std::vector<size_t> widths;
  std::vector<bool> numbers;  // whether all cells below the title are numbers
};

Columns find_columns(const std::vector<std::vector<std::string>>& rows) {
  Columns out;
  for (size_t r = 0; r < rows.size(); ++r) {
    out.widths.resize(std::max(out.widths.size(), rows[r].size()), 0);
    out.numbers.resize(out.widths.size(), true);
    for (size_t c = 0; c < rows[r].size(); ++c) {
      out.widths[c] = std::max(out.widths[c], count_characters(rows[r][c]));
      if (r > 0 && !is_number(rows[r][c])) out.numbers[c] = false;
    }
  }
  return out;
}

}  // namespace

Json to_json(const Error& error) {
  Json out{{"code", static_cast<int>(error.code)},
           {"id", "WEIR-" + std::to_string(static_cast<int>(error.code))},
           {"what", error.what}};
  const auto add = [&out](const char* name, const std::string& part) {
    if (!part.empty()) out[name] = part;
  };
  add("offered", error.offered);
  add("needed", error.needed);
  add("difference", error.difference);
  add("fix", error.fix);
  return out;
}

void print(const Json& document) {
  const std::string text = document.dump(2, ' ', false, Json::error_handler_t::replace);
  std::puts(for_terminal(text).c_str());
}

int report(const Error& error, bool json) {
  if (json)
    print(Json{{"error", to_json(error)}});
  else
    std::fprintf(stderr, "%s\n", coloured_error(stderr, error.message()).c_str());
  return kExitError;
}

std::string table(std::vector<std::vector<std::string>> rows, std::string_view indent) {
  for (auto& row : rows)
    for (auto& cell : row) {
      std::replace_if(cell.begin(), cell.end(), is_control, ' ');
      cell = printable_text(cell);
    }
  const auto [widths, numbers] = find_columns(rows);
  std::string out;
  for (const auto& row : rows) {
    std::string line(indent);
    for (size_t c = 0; c < row.size(); ++c) {
      const std::string blanks(widths[c] - count_characters(row[c]), ' ');
      line += (c ? "  " : "") + (numbers[c] ? blanks + row[c] : row[c] + blanks);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  }
  return out;
}

}  // namespace weir::app
