// The modes of tensor_decoder that a model card may name, and the options of each.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string_view>

namespace weir::card {

// What the value of an option may be.
enum class Value {
  Text,
  Fraction,    // 0 to 1
  Count,       // 0 to 65536
  File,        // the name of a file beside the card
  Files,       // several, separated by ;
  FileFirst,   // a file, then :PARAMETERS
  Parameters,  // option3 of bounding_boxes: depends on the scheme, which is option1
};

struct DecoderOption {
  std::string_view name;
  Value value = Value::Text;
};

// A mode that comes with Weir and runs no code of others. Modes with named options take those that
// are no properties of tensor_decoder in the property `custom`.
struct DecoderMode {
  std::string_view name;
  std::span<const DecoderOption> options;

  // Returns null if the mode does not have it.
  const DecoderOption* option(std::string_view name) const noexcept;
  // Returns whether the options are numbered, option1 to option9, rather than named.
  bool is_numbered() const noexcept;
};

std::span<const DecoderMode> decoder_modes() noexcept;
// Returns null for any other name.
const DecoderMode* find_decoder_mode(std::string_view name) noexcept;
// Returns whether tensor_decoder has a property with this name besides `custom`.
bool is_decoder_property(const DecoderOption& option) noexcept;

}  // namespace weir::card
