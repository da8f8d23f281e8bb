// Fuzz target: parses properties that have a grammar. The first byte selects the property.
// Rejections have a text, and formatted shapes and types parse to the same value.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <string>

#include "core/convert/converter_mode.hpp"
#include "core/filter/combination.hpp"
#include "core/filter/layout_list.hpp"
#include "core/infer/module/accelerator.hpp"
#include "core/preprocess/request.hpp"
#include "core/rate/frame_rate.hpp"
#include "core/text/error_text.hpp"
#include "core/text/text.hpp"
#include "core/trace/options.hpp"
#include "core/window/window.hpp"
#include "fuzz_input.hpp"
#include "weir/abi.h"

namespace {

using namespace weir;
using fuzz::FuzzInput;
using fuzz::require;

template <class T>
bool accepted(const Result<T>& result) {
  if (!result) require(!result.error().what.empty(), "an error has a text");
  return static_cast<bool>(result);
}

void check_shapes(std::string_view text) {
  const auto shapes = parse_shape_list(text);
  if (!accepted(shapes)) return;
  std::vector<TensorSpec> specs;
  for (const auto& shape : *shapes) {
    specs.push_back({ElementType::UInt8, shape, ""});
    if (!shape.valid()) return;
  }
  const auto again = parse_shape_list(join_shapes(specs));
  require(accepted(again) && *again == *shapes, "shapes come back from their text");
}

void check_types(std::string_view text) {
  const auto types = parse_type_list(text);
  if (!accepted(types)) return;
  std::vector<TensorSpec> specs;
  for (const auto type : *types) specs.push_back({type, Shape{1u}, ""});
  const auto again = parse_type_list(join_types(specs));
  require(accepted(again) && *again == *types, "types come back from their text");
}

void check_window(FuzzInput* input) {
  window::WindowRequest request;
  for (uint32_t* frames : {&request.frames_in, &request.frames_out})
    *frames = std::max<uint32_t>(1, input->flag() ? input->take<uint32_t>() : input->byte());
  request.frames_flush = input->flag() ? input->take<uint32_t>() : input->byte();
  request.dimension = input->below(kRankLimit);
  request.concatenate = input->flag();
  const auto type = static_cast<ElementType>(input->below(11));
  const TensorSpec spec{type, Shape::parse(input->text()), ""};
  if (!spec.valid() || !spec.bytes()) return;
  const auto plan = window::plan(request, {spec});
  if (!accepted(plan)) return;
  require(plan->output.size() == 1 && plan->layouts.size() == 1 && plan->output[0].bytes(),
          "a window has a size");
  const auto& layout = plan->layouts[0];
  require(layout.block_bytes > 0 && layout.frame_bytes % layout.block_bytes == 0,
          "blocks fill a frame");
  require(fuzz::multiplies_to(layout.frame_bytes, plan->out, *plan->memory.at(0).bytes()),
          "frames fill a window");
}

void check_accelerator(std::string_view text) {
  std::optional<Error> warning;
  const auto requested = infer::parse_accelerator(text, &warning);
  const auto chosen = infer::choose_accelerator(requested, {"cpu", "cpu.simd", "gpu"});
  require(chosen.find(' ') == chosen.npos, "an accelerator is a list of names");
}

void check_preprocess(FuzzInput* input) {
  const auto first = input->line(), second = input->line(), rest = input->text();
  accepted(preprocess::parse_quantisation(first));
  accepted(preprocess::parse_type(second));
  if (const auto sizes = preprocess::parse_sizes(first); accepted(sizes))
    require(!sizes->empty() && sizes->size() <= preprocess::kLayerLimit, "layers have a limit");
  if (const auto crop = preprocess::parse_crop(second); accepted(crop))
    require(crop->width > 0 && crop->height > 0, "a crop has an area");
  if (const auto numbers = preprocess::parse_numbers("mean", rest); accepted(numbers))
    for (const double number : *numbers) require(std::isfinite(number), "a number is finite");
}

void check_text(FuzzInput* input) {
  const size_t position = input->take<uint16_t>();
  const auto text = input->text();
  require(!place_in(text, std::min(position, text.size())).empty(), "a place has a text");
  const std::string words[] = {"slowest", "basepad", "refresh", std::string(text.substr(0, 5))};
  (void)nearest(text, words);
  if (const auto number = parse_unsigned(text))
    require(parse_unsigned(std::to_string(*number)) == number, "a number comes back");
  if (const auto number = parse_signed(text))
    require(parse_signed(std::to_string(*number)) == number, "a number comes back");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput input(data, size);
  switch (input.below(12)) {
    case 0:
      check_shapes(input.text());
      break;
    case 1:
      check_types(input.text());
      break;
    case 2:
      if (const auto rate = parse_frame_rate(input.text()); accepted(rate) && *rate)
        require((*rate)->valid() && (*rate)->numerator > 0, "a rate is above 0");
      break;
    case 3:
      accepted(parse_converter_mode(input.text()));
      break;
    case 4:
      check_accelerator(input.text());
      break;
    case 5: {
      std::optional<Error> warning;
      for (const auto layout : parse_layout_list(input.text(), "inputlayout", &warning))
        require(layout <= WEIR_LAYOUT_NONE, "a layout is known");
      break;
    }
    case 6:
      accepted(parse_input_combination(input.text()));
      accepted(parse_output_combination(input.text()));
      break;
    case 7:
      accepted(trace::read_options(input.text()));
      break;
    case 8:
      check_window(&input);
      break;
    case 9:
      check_preprocess(&input);
      break;
    case 10:
      (void)parse_name_list(input.text());
      (void)parse_format(input.text());
      break;
    default:
      check_text(&input);
  }
  return 0;
}
