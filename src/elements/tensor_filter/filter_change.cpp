// The list of them.
#include "elements/tensor_filter/filter_change.hpp"

#include <algorithm>
#include <tuple>

#include "core/tensor/frame_spec.hpp"

namespace weir {
namespace {

using S = FilterSettings;
auto fields(S& s) {
  return std::tie(s.framework, s.input, s.inputtype, s.inputname, s.inputlayout, s.output,
                  s.outputtype, s.outputname, s.outputlayout, s.custom, s.accelerator,
                  s.input_combination, s.output_combination, s.shared_tensor_filter_key,
                  s.invoke_dynamic, s.suspend);
}
auto fields(const S& s) {
  return fields(const_cast<S&>(s));
}

}  // namespace

bool opens_the_model(std::string_view property) {
  static constexpr std::string_view kNames[] = {"framework",          "input",
                                                "inputtype",          "inputname",
                                                "inputlayout",        "output",
                                                "outputtype",         "outputname",
                                                "outputlayout",       "custom",
                                                "accelerator",        "input-combination",
                                                "output-combination", "shared-tensor-filter-key",
                                                "invoke-dynamic",     "suspend"};
  return std::ranges::find(kNames, property) != std::end(kNames);
}

void copy_model_settings(const FilterSettings& from, FilterSettings* to) {
  fields(*to) = fields(from);
}

Status check_lists(const FilterSettings& s) {
  for (const auto* text : {&s.input, &s.output})
    if (!text->empty())
      if (const auto shapes = parse_shape_list(*text); !shapes) return shapes.error();
  for (const auto* text : {&s.inputtype, &s.outputtype})
    if (!text->empty())
      if (const auto types = parse_type_list(*text); !types) return types.error();
  return ok();
}

}  // namespace weir
