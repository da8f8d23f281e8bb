// Fuzz target: parses tensor_transform's options and runs their plans on a small tensor. The first
// byte selects the mode, the next three the type and shape. The scalar and the vector path must
// agree.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <vector>

#include "core/transform/transform.hpp"

namespace {

std::vector<std::byte> applied(const weir::transform::Operation& operation,
                               const weir::TensorSpec& spec, bool accelerate) {
  constexpr uint64_t kMax = 1 << 20;  // bytes: a padding may request far more
  const auto plan = weir::transform::plan(operation, spec, accelerate);
  if (!plan || *plan->output().bytes() > kMax) return {};
  std::vector<std::byte> in(*spec.bytes()), out(*plan->output().bytes());
  for (size_t i = 0; i < in.size(); ++i) in[i] = static_cast<std::byte>(i * 37);
  plan->apply(in, out);
  return out;
}

// Bit-exact, except that a 16-bit signalling NaN may have become quiet.
bool same(const std::vector<std::byte>& a, const std::vector<std::byte>& b, bool halves) {
  if (a.size() != b.size()) return false;
  if (!halves) return std::memcmp(a.data(), b.data(), a.size()) == 0;
  for (size_t i = 0; i + 1 < a.size(); i += 2) {
    uint16_t x, y;
    std::memcpy(&x, a.data() + i, 2);
    std::memcpy(&y, b.data() + i, 2);
    if (x != y && ((x & 0x7FFF) <= 0x7C00 || (y & 0x7FFF) <= 0x7C00)) return false;
  }
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using weir::transform::Mode;
  if (size < 4) return 0;
  const std::string_view option(reinterpret_cast<const char*>(data) + 4, size - 4);
  const auto operation = weir::transform::parse(static_cast<Mode>(data[0] % 8 - 1), option);
  if (!operation) return 0;
  const weir::TensorSpec spec{static_cast<weir::ElementType>(data[1] % 11),
                              weir::Shape{data[2] % 9u + 1, data[3] % 9u + 1, 3u}, ""};
  const auto plain = applied(*operation, spec, false), fast = applied(*operation, spec, true);
  const auto output = weir::transform::output_spec(*operation, spec);
  if (output && !same(plain, fast, output->type == weir::ElementType::Float16)) std::abort();
  return 0;
}
