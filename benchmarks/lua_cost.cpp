// Measures Lua scripts: loops over the elements of a frame against the same loop in C, and a frame
// through tensor_filter against a plain call of LuaJIT. Minimum CPU time of the rounds.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "element_stage.hpp"
#include "lua/lua_api.hpp"
#include "rounds.hpp"

namespace {

constexpr int kFrames = 100, kCalls = 3000;
constexpr size_t kElements = 224 * 224 * 3;

// A straightforward loop; not inlined, so that the compiler knows no more than the script.
template <class From, class To>
[[gnu::noinline]] void plain_loop(const From* from, To* to, size_t count) {
  for (size_t i = 0; i < count; ++i) to[i] = static_cast<To>(from[i]);
}
template <class From, class To>
void plain_loops() {
  static std::vector<From> from(kElements, From{1});
  static std::vector<To> to(kElements);
  for (int i = 0; i < kFrames; ++i) plain_loop(from.data(), to.data(), kElements);
}

std::string caps(const char* type, size_t elements) {
  return std::string("other/tensors,format=static,num_tensors=1,dimensions=(string)") +
         std::to_string(elements) + ",types=(string)" + type + ",framerate=(fraction)30/1";
}

class Script {
 public:
  Script(const std::string& folder, const char* from, const char* to, size_t elements,
         const std::string& body)
      : path_(folder + "/" + from + "_" + to + "_" + std::to_string(elements) + ".lua"),
        caps_(caps(from, elements)) {
    const auto table = [elements](const char* name, const char* type) {
      return std::string(name) + "TensorsInfo = {num = 1, dim = {{" + std::to_string(elements) +
             "}}, type = {'" + type + "'}}\n";
    };
    std::ofstream(path_) << table("input", from) << table("output", to)
                         << "function nnstreamer_invoke()\n" + body + "\nend\n";
  }
  std::string filter() const { return "tensor_filter framework=lua model=" + path_; }
  const char* caps_text() const { return caps_.c_str(); }

 private:
  std::string path_, caps_;
};

constexpr char kLoop[] =
    "local x, y = input_tensor(1), output_tensor(1)\nfor i = 1, #x do y[i] = x[i] end";

// A function without arguments, called as the engine does.
class BareCall {
 public:
  explicit BareCall(const weir::engine::LuaApi& api) : api_(api), state_(api.luaL_newstate()) {
    const char kText[] = "return function() end";
    api_.luaL_loadbufferx(state_, kText, sizeof kText - 1, "bare", "t");
    api_.lua_pcall(state_, 0, 1, 0);
    function_ = api_.luaL_ref(state_, weir::engine::kLuaRegistry);
  }
  ~BareCall() { api_.lua_close(state_); }
  void run(int calls) {
    for (int i = 0; i < calls; ++i) {
      api_.lua_rawgeti(state_, weir::engine::kLuaRegistry, function_);
      api_.lua_pcall(state_, 0, 0, 0);
    }
  }

 private:
  const weir::engine::LuaApi& api_;
  lua_State* state_;
  int function_ = 0;
};

}  // namespace

// Usage: lua_cost FOLDER ROUNDS. Exit status 3: LuaJIT is not installed.
int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  if (argc != 3) return 2;
  const auto api = weir::engine::LuaApi::instance();
  if (!api) return 3;
  const std::string folder = argv[1];
  const Script to_float(folder, "uint8", "float32", kElements, kLoop);
  const Script floats(folder, "float32", "float32", kElements, kLoop);
  const Script bytes(folder, "uint8", "uint8", kElements, kLoop);
  const Script small(folder, "uint8", "uint8", 1024, "");
  using weir::bench::ElementStage;
  ElementStage to_float_stage(to_float.filter(), to_float.caps_text(), kElements);
  ElementStage float_stage(floats.filter(), floats.caps_text(), kElements * sizeof(float));
  ElementStage byte_stage(bytes.filter(), bytes.caps_text(), kElements);
  ElementStage small_stage(small.filter(), small.caps_text(), 1024);
  BareCall bare(**api);
  const auto costs = weir::bench::min(
      {[] { plain_loops<uint8_t, float>(); }, [&] { to_float_stage.push(kFrames); },
       [] { plain_loops<float, float>(); }, [&] { float_stage.push(kFrames); },
       [] { plain_loops<uint8_t, uint8_t>(); }, [&] { byte_stage.push(kFrames); },
       [&] { bare.run(kCalls); }, [&] { small_stage.push(kCalls); }},
      std::atoi(argv[2]));
  const auto loop = [&](const char* what, size_t index) {
    const double floor = costs[index].cpu / kFrames * 1e6;
    weir::bench::report(std::string("tensor_filter, a loop in Lua, ") + what + ": CPU",
                        "the loop in C, " + std::to_string(static_cast<int>(floor)) + " us",
                        costs[index + 1].cpu / costs[index].cpu, "x", 2);
  };
  loop("uint8 to float32", 0);
  loop("identity of float32", 2);
  loop("identity of uint8", 4);
  weir::bench::report("tensor_filter framework=lua, 1 KB and no loop: CPU above it",
                      "a bare call of LuaJIT", (costs[7].cpu - costs[6].cpu) / kCalls * 1e6, "us",
                      20);
}
