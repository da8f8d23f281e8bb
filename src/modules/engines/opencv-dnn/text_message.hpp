// TextMessage: a message in protobuf's text format, as in Caffe's .prototxt files, parsed without
// its schema: protobuf.dev/reference/protobuf/textformat-spec.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "weir/result.hpp"

namespace weir::engine {

struct TextMessage {
  struct Field {
    std::string name, value;               // value without the quotes of a string
    std::unique_ptr<TextMessage> message;  // set when the value is a message
  };
  std::vector<Field> fields;

  std::string text(std::string_view name) const;               // of the first such field, or ""
  std::optional<int64_t> number(std::string_view name) const;  // of the first such number
  std::vector<int64_t> numbers(std::string_view name) const;
  std::vector<const TextMessage*> messages(std::string_view name) const;
};

// MODEL_INVALID gives the line.
Result<TextMessage> read_text_message(std::string_view text);

}  // namespace weir::engine
