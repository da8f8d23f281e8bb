// The engines that Weir knows by name, NNStreamer's among them: aliases, extensions and install
// commands.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string_view>
#include <vector>

namespace weir::infer {

struct KnownEngine {
  std::string_view name;     // of the module file: libweir-engine-NAME.so
  std::string_view aliases;  // comma-separated other values of framework=
  std::string_view extensions;
  std::string_view install;           // the install command; "" = not available for Weir yet
  std::string_view alternative = {};  // what Weir can run instead, for messages; "" = nothing
};

std::span<const KnownEngine> known_engines() noexcept;
// Finds an engine by name or alias; null if unknown.
const KnownEngine* known_engine(std::string_view word) noexcept;
// The engines for a file extension: the first installed one is chosen
// (docs/compatibility/filter.md 4.2); empty if only the table of engines decides.
std::vector<std::string_view> preferred_engines(std::string_view extension);
// Finds an engine by the file's extension in lower case without the dot; null if there is none.
const KnownEngine* known_engine_for(std::string_view extension) noexcept;

}  // namespace weir::infer
