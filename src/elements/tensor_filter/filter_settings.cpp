// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/filter_settings.hpp"

#include <charconv>

#include "core/tensor/frame_spec.hpp"
#include "core/text/text.hpp"

namespace weir {

Status check_lists(const FilterSettings& s) {
  for (const auto* text : {&s.input, &s.output})
    if (!text->empty())
      if (const auto shapes = parse_shape_list(*text); !shapes) return shapes.error();
  for (const auto* text : {&s.inputtype, &s.outputtype})
    if (!text->empty())
      if (const auto types = parse_type_list(*text); !types) return types.error();
  return ok();
}

infer::ThreadUse thread_use(const FilterSettings& settings) {
  infer::ThreadUse use{static_cast<int>(settings.workers * settings.invoke_threads),
                       settings.threads};
  for (const auto option : split(settings.custom, ",")) {
    const size_t colon = option.find(':');
    if (colon == std::string_view::npos) continue;
    if (!equal_ignoring_case(strip(option.substr(0, colon)), "NumThreads")) continue;
    const auto text = strip(option.substr(colon + 1));
    int number = 0;  // the engine rejects what is not a number
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error == std::errc() && end == text.data() + text.size() && number > 0 && number <= 1024)
      use.threads = number;
  }
  return use;
}

}  // namespace weir
