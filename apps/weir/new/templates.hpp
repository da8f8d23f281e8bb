// The files that `weir new filter` writes, from apps/weir/new/templates/filter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string_view>

namespace weir::app {

struct Template {
  std::string_view language;  // "c", "c++", "python", "lua"
  std::string_view file;      // file name in the new folder
  std::string_view text;      // text for a filter called my-filter with a class MyFilter
};

std::span<const Template> filter_templates() noexcept;

}  // namespace weir::app
