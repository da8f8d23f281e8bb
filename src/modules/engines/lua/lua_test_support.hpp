// Fixture with scripts for tests of the Lua engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "engine_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {

// A script with one input and one output of `elements` each, and `body` in nnstreamer_invoke.
inline std::string script_text(const std::string& body, const std::string& in = "float32",
                               const std::string& out = "float32", int elements = 4) {
  const auto table = [&](const std::string& name, const std::string& type) {
    return name + "TensorsInfo = {num = 1, dim = {{" + std::to_string(elements) + "}}, type = {'" +
           type + "'}}\n";
  };
  return table("input", in) + table("output", out) +
         "function nnstreamer_invoke()\n  local x, y = input_tensor(1), output_tensor(1)\n" + body +
         "\nend\n";
}

class LuaTest : public EngineTest {
 protected:
  static std::vector<std::byte> to_bytes(const std::string& text) {
    const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
    return {bytes, bytes + text.size()};
  }
  std::unique_ptr<OpenEngine> script(const std::string& text, const Options& options = {}) {
    return opened(to_bytes(text), options);
  }
  Error refusal(const std::string& text, const Options& options = {}) {
    return get_error(to_bytes(text), options);
  }
  // The error of the first frame: four zeros of float32.
  Error failure(const std::string& body, const Options& options = {}) {
    const auto model = open(to_bytes(script_text(body)), options);
    if (!model) return model.error();
    const auto out = (*model)->invoke({make_tensor(WEIR_FLOAT32, {4})});
    return out ? Error{.code = Code::INTERNAL, .what = "it ran"} : out.error();
  }
  // The four float32 elements of y for x = 1, 2, 3, 4.
  std::vector<float> result(const std::string& body, const Options& options = {}) {
    const auto model = script(script_text(body), options);
    if (!model) return {};
    const auto out = model->invoke({make_tensor<float>(WEIR_FLOAT32, {4}, {1, 2, 3, 4})});
    if (!out) ADD_FAILURE() << out.error().message();
    return out ? (*out)[0].values<float>() : std::vector<float>{};
  }
};

}  // namespace weir::engine_test
