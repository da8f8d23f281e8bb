// `weir new`: folders with a filter, engine, decoder or converter to begin with.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace weir::app {

struct NewModuleOptions {
  std::string kind;      // "filter", "engine", "decoder", "converter"
  std::string language;  // of a filter: "c", "c++", "python", "lua"; the others are in C++
  std::string name;      // of the filter, engine, ... and of the new folder
};
// Writes a folder with a source, a build, a README and a test. new_filter() is this for filters.
int new_module(const NewModuleOptions& options);

}  // namespace weir::app
