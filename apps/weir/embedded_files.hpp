// Files of the sources that the command has in it: apps/weir/embed.py writes them at build time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string_view>

namespace weir::app {

struct EmbeddedFile {
  std::string_view group, name, text;
};

// What `weir new filter` writes, from apps/weir/new/templates/filter. group: the language, "c",
// "c++", "python" or "lua"; name: that of the file in the new folder; text: for a filter called
// my-filter with a class MyFilter.
std::span<const EmbeddedFile> filter_templates() noexcept;

// What `weir explain` prints, from docs/errors. group: "errors"; name: "WEIR-1001.md".
std::span<const EmbeddedFile> error_pages() noexcept;

}  // namespace weir::app
