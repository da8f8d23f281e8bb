// The property accelerator (specification 4.4): "true:npu,gpu,!cpu.simd".
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "weir/result.hpp"

namespace weir::infer {

struct AcceleratorWish {
  enum class Kind { EngineDefault, None, Hardware } kind = Kind::EngineDefault;
  // In the user's order, in lower case; none listed: the engine's automatic choice.
  std::vector<std::string> names, excluded;
};

// (true|false)[:acc[,acc...]], the list maybe in parentheses, in any case; "" = the engine's
// default. What does not match means no accelerator; `warning` (may be null) says so.
AcceleratorWish parse_accelerator(std::string_view text, std::optional<Error>* warning = nullptr);

// What weir_open.accelerator says: "" = the engine's default, "none", "auto", or names. `supported`
// is the engine's own list, its automatic choice first, and one name is chosen: the first wish that
// it supports, else its automatic one. Where the engine gives no list it gets all wishes,
// "npu,gpu".
std::string choose_accelerator(const AcceleratorWish& wish,
                               const std::vector<std::string>& supported);

// The number of a name: two names of one number are the same hardware.
std::optional<unsigned> accelerator_number(std::string_view name) noexcept;

}  // namespace weir::infer
