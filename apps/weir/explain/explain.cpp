// `weir explain CODE`: prints the page of an error code; without a code, all codes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <string>
#include <vector>

#include "commands.hpp"
#include "core/text/text.hpp"
#include "embedded_files.hpp"
#include "report.hpp"
#include "weir/codes.h"

namespace weir::app {
namespace {

struct CodeTitle {
  const char* id;
  const char* title;
};
constexpr CodeTitle kCodes[] = {
#define WEIR_CODE_TITLE(name, number, title) {"WEIR-" #number, title},
    WEIR_ERROR_CODES(WEIR_CODE_TITLE)
#undef WEIR_CODE_TITLE
};

int list_codes() {
  std::vector<std::vector<std::string>> rows{{"code", "meaning"}};
  for (const auto& [id, title] : kCodes) rows.push_back({id, title});
  std::fputs(table(std::move(rows), "").c_str(), stdout);
  std::puts("\nweir explain WEIR-2001 shows what a code means and how to fix it.");
  return kExitGood;
}

// "WEIR-2001" for "2001" and "weir-2001".
std::string id_from(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  const bool has_prefix = text.rfind("WEIR-", 0) == 0;
  return has_prefix ? text : "WEIR-" + text;
}

Error unknown_code(const std::string& code, const std::string& id) {
  std::vector<std::string> ids;
  for (const auto& known : kCodes) ids.emplace_back(known.id);
  const std::string close = nearest(id, ids);
  return {.code = Code::OPTION_VALUE,
          .what = "there is no such error code",
          .offered = code,
          .needed = "a code such as WEIR-2001, which begins each error message",
          .difference = close.empty() ? "" : "did you mean " + close + "?",
          .fix = close.empty() ? "weir explain" : "weir explain " + close};
}

}  // namespace

int explain(const std::string& code) {
  if (code.empty()) return list_codes();
  const std::string id = id_from(code);
  for (const auto& page : error_pages()) {
    if (page.name != id + ".md") continue;
    std::fwrite(page.text.data(), 1, page.text.size(), stdout);
    return kExitGood;
  }
  return report(unknown_code(code, id), false);
}

}  // namespace weir::app
