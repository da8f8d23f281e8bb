// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lua/lua_options.hpp"

#include <algorithm>
#include <array>

#include "store_option.hpp"
#include "weir/engine_tools.hpp"
#include "weir/join.hpp"

namespace weir::engine {
namespace {

constexpr int kMaxMebibytes = 1 << 20;

// Splits "io+os". Blanks and semicolons also separate; commas already separate options.
Result<std::vector<std::string>> read_libraries(std::string_view text) {
  std::vector<std::string> out;
  const auto& known = withheld_libraries();
  while (!text.empty()) {
    const size_t end = std::min(text.find_first_of("+; "), text.size());
    const std::string name(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (name.empty()) continue;
    if (std::find(known.begin(), known.end(), name) == known.end())
      return Error{.code = Code::OPTION_VALUE,
                   .what = "the option Libraries names an unknown library",
                   .offered = name,
                   .needed = "of " + join(known, ", ") + ", separated by +",
                   .fix = "custom=Libraries:io+os"};
    out.push_back(name);
  }
  return out;
}

Status apply(const weir_option& option, LuaOptions* out) {
  const auto key = text_or_empty(option.key), value = text_or_empty(option.value);
  if (equals_ignoring_case(key, "Libraries"))
    return store_option(read_libraries(value), &out->libraries);
  if (equals_ignoring_case(key, "Sandbox"))
    return store_option(switch_option(key, value), &out->sandbox);
  if (equals_ignoring_case(key, "MemoryLimit")) {
    const auto limit = number_option(key, value, 1);
    if (!limit) return limit.error();
    out->memory_limit = static_cast<uint64_t>(std::min(*limit, kMaxMebibytes));
  } else {
    warn_unknown_option(key, "Libraries, MemoryLimit, Sandbox");
  }
  return ok();
}

}  // namespace

const std::vector<std::string>& withheld_libraries() {
  static const std::vector<std::string> names{"io", "os", "package", "debug", "jit", "ffi"};
  return names;
}

bool LuaOptions::opens(const char* library) const {
  static constexpr std::array<std::string_view, 4> kStandard{"io", "os", "package", "debug"};
  if (!sandbox && std::find(kStandard.begin(), kStandard.end(), library) != kStandard.end())
    return true;
  return std::find(libraries.begin(), libraries.end(), library) != libraries.end();
}

Result<LuaOptions> LuaOptions::read(const weir_open& request) {
  LuaOptions out;
  for (uint32_t i = 0; request.options && i < request.n_options; ++i)
    if (auto status = apply(request.options[i], &out); !status) return status.error();
  return out;
}

}  // namespace weir::engine
