// The files that `weir new filter` writes: those below apps/weir/templates/filter.
#pragma once
#include <span>
#include <string_view>

namespace weir::app {

struct Template {
  std::string_view language;  // "c", "c++", "python", "lua"
  std::string_view file;      // its name in the new folder
  std::string_view text;      // of a filter called my-filter, with a class MyFilter
};

std::span<const Template> filter_templates() noexcept;

}  // namespace weir::app
