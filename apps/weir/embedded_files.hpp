// Files of the sources that the command has in it: apps/weir/embed.py writes them at build time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string_view>

namespace weir::app {

struct EmbeddedFile {
  std::string_view group, name, text;
};

// What `weir new` writes, from apps/weir/new/templates. group: the language of a filter, "c",
// "c++", "python" or "lua", or the kind of a module, "engine"; name: that of the file in the new
// folder; text: for a filter called my-filter with a class MyFilter, an engine called my-engine.
// KIND stands for the kind of a module.
std::span<const EmbeddedFile> module_templates() noexcept;

// What `weir explain` prints, from docs/errors. group: "errors"; name: "WEIR-1001.md".
std::span<const EmbeddedFile> error_pages() noexcept;

}  // namespace weir::app
