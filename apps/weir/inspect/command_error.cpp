// SPDX-License-Identifier: LGPL-2.1-or-later
#include "inspect/command_error.hpp"

#include <string>
#include <string_view>

#include "core/infer/module/model_file.hpp"
#include "core/text/shell_quote.hpp"

namespace weir::app {
namespace {

// Replaces `property` wherever a word begins with it.
void replace(std::string* text, std::string_view property, std::string_view option) {
  for (size_t at = 0; (at = text->find(property, at)) != std::string::npos;) {
    if (at > 0 && (*text)[at - 1] != ' ') {
      at += property.size();
      continue;
    }
    text->replace(at, property.size(), option);
    at += option.size();
  }
}

}  // namespace

Error command_error(Error error) {
  for (auto* part : {&error.offered, &error.needed, &error.fix}) {
    replace(part, "framework=", "--engine ");
    replace(part, "card=", "--card ");
    replace(part, "model=", "");
  }
  // A value in a pipeline has other quotes than a word of a command.
  if (error.code == Code::MODEL_NOT_FOUND)
    if (const auto similar = infer::similar_model_file(error.offered);
        !similar.empty() && !error.fix.empty())
      error.fix = shell_word(similar);
  return error;
}

}  // namespace weir::app
