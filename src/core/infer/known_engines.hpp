// The engines Weir knows by name: what else they are called, and how a machine gets them.
#pragma once
#include <span>
#include <string_view>
#include <vector>

namespace weir::infer {

struct KnownEngine {
  std::string_view name;     // of the module file: libweir-engine-NAME.so
  std::string_view aliases;  // comma list of the words users write for framework=
  std::string_view extensions;
  std::string_view install;  // the command that brings it; "" = not available for Weir yet
};

std::span<const KnownEngine> known_engines() noexcept;
// By name or alias, null when unknown.
const KnownEngine* known_engine(std::string_view word) noexcept;
// For a file extension, the engines of which the first that is installed is taken (specification
// 4.2); empty where the table of engines decides alone.
std::vector<std::string_view> preferred_engines(std::string_view extension);
// By file extension without the dot, in lower case; null when none claims it.
const KnownEngine* known_engine_for(std::string_view extension) noexcept;

}  // namespace weir::infer
