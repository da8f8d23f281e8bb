// `nnstreamerCodeGenCustomFilter`: prompts for the options of `weir new nnstreamer-filter`
// (docs/compatibility/app-api.md 8.4).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdio>
#include <iostream>
#include <string>

#include "commands.hpp"
#include "core/text/text.hpp"
#include "report.hpp"
#include "weir/result.hpp"

namespace weir::app {
namespace {

Error unanswered() {
  return Error{.code = Code::OPTION_VALUE,
               .what = "the input ended before every question was answered",
               .needed = "a name, the file's name, and yes or no twice",
               .fix = "weir new nnstreamer-filter NAME"};
}

// Returns the typed line, or `otherwise` if it is empty.
Result<std::string> ask(const std::string& question, const std::string& otherwise) {
  std::printf("%s%s: ", question.c_str(),
              otherwise.empty() ? "" : (" [" + otherwise + "]").c_str());
  std::fflush(stdout);
  std::string line;
  if (!std::getline(std::cin, line)) return unanswered();
  const auto answer = strip(line);
  return answer.empty() ? otherwise : std::string(answer);
}

Result<bool> ask_whether(const std::string& question, const std::string& otherwise) {
  const auto answer = ask(question, otherwise);
  if (!answer) return answer.error();
  for (const char* word : {"y", "yes", "n", "no"})
    if (equal_ignoring_case(*answer, word)) return word[0] == 'y';
  return Error{.code = Code::OPTION_VALUE,
               .what = "the answer is neither yes nor no",
               .offered = *answer,
               .needed = "yes or no",
               .fix = otherwise};
}

Status ask_all(CustomClassOptions* options) {
  auto name = ask("Name of the filter, as in C", "");
  if (!name) return name.error();
  auto base = ask("Name of the file, after nnstreamer_customfilter_", *name);
  if (!base) return base.error();
  const auto fixed = ask_whether("Are the sizes of its tensors fixed?", "yes");
  if (!fixed) return fixed.error();
  const auto allocates = ask_whether("Does invoke allocate the outputs?", "no");
  if (!allocates) return allocates.error();
  *options = {*std::move(name), *std::move(base), *fixed, *allocates};
  return ok();
}

}  // namespace

int ask_for_filter() {
  CustomClassOptions options;
  const auto status = ask_all(&options);
  std::puts("");
  return status ? new_custom_class(options) : report(status.error(), false);
}

}  // namespace weir::app
