// Fuzz target: the tables and tensors of Lua scripts. The input becomes numbers that a script
// returns whenever one of its tables is read, plain or through metatables, and indices that it
// reads and writes in each frame. Arbitrary script text would soon loop endlessly, so the text is
// fixed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>
#include <string>
#include <vector>

#include "core/infer/module/host.hpp"
#include "guarded_memory.hpp"
#include "lua/lua_model.hpp"
#include "lua/lua_runner.hpp"
#include "weir/engine_tools.hpp"

namespace {

using namespace weir::engine;
using weir::fuzz::FuzzInput;
using weir::fuzz::require;

constexpr uint64_t kMaxBytes = 1 << 16;  // per tensor of a given frame

constexpr char kScript[] = R"(
local at = 0
local function answer()
  if #answers == 0 then return 1 end
  at = at + 1
  return answers[(at - 1) % #answers + 1]
end
-- A list whose first and last entries are there. Each read of another one gets the next answer.
local function list(plain)
  if not changing then return plain end
  local reads = {}
  return setmetatable(holes(answers[1] or 1), {__index = function(_, key)
    if type(key) ~= 'number' or key < 1 then return nil end
    reads[key] = (reads[key] or 0) + 1
    return answers[(reads[key] - 1) % #answers + 1]
  end})
end
local function info()
  local dimensions, types = {}, {}
  for i = 1, tensors do
    local one = {}
    for d = 1, rank do one[d] = answer() end
    dimensions[i] = list(one)
    types[i] = kinds[(i - 1) % #kinds + 1]
  end
  return setmetatable({num = tensors, dim = dimensions, type = types}, {__index = answer})
end
inputTensorsInfo = info()
outputTensorsInfo = info()
function nnstreamer_invoke()
  for i = 1, tensors do
    local from, to = input_tensor(i), output_tensor(i)
    pcall(function() to[math.floor(#to)] = from[math.floor(#from)] end)
    for _, place in ipairs(answers) do
      pcall(function() to[place] = from[place] end)
      pcall(function() to[#to + place] = from[#from] end)
      pcall(function() from[place] = answer() end)
    end
  end
end
)";

std::string format_number(double number) {
  if (number != number) return "0/0";
  char out[40];
  std::snprintf(out, sizeof out, "%.17g", number);
  return std::string(out).find("inf") == std::string::npos ? out : number < 0 ? "-1/0" : "1/0";
}

std::string make_script(FuzzInput* input) {
  static constexpr std::array kTypes{"uint8",  "int64",  "float16", "float32",
                                     "uint64", "UINT16", "none"};
  std::string out = "changing = " + std::string(input->flag() ? "true" : "false");
  out += "\ntensors = " + std::to_string(input->below(4));
  const uint32_t rank = input->below(18);
  out += "\nrank = " + std::to_string(rank) + "\nfunction holes(edge) return {edge";
  for (uint32_t i = 2; i < rank; ++i) out += ", nil";
  out += rank > 1 ? ", edge} end" : "} end";
  out += "\nkinds = {'" + std::string(kTypes[input->below(kTypes.size())]) + "', '" +
         kTypes[input->below(kTypes.size())] + "'}\nanswers = {";
  for (int i = 0; i < 64 && !input->empty(); ++i) {
    const bool whole = input->flag();
    out += format_number(whole ? input->take<int8_t>() : input->take<double>()) + ", ";
  }
  return out + "}\n" + kScript;
}

// A frame with separate memory for each tensor, in the sizes of the script's tables.
struct Frame {
  std::vector<weir::fuzz::GuardedMemory> memories;
  std::vector<weir_tensor> tensors;
  weir_frame frame{};

  explicit Frame(const std::vector<weir_tensor_info>& infos) {
    for (const auto& info : infos) {
      uint64_t bytes = 8;
      for (uint32_t i = 0; i < info.rank; ++i)
        bytes = std::min<uint64_t>(kMaxBytes, bytes * static_cast<uint64_t>(info.shape[i]));
      constexpr uint64_t kSizes[] = {4, 4, 2, 2, 1, 1, 8, 4, 8, 8, 2};
      memories.emplace_back(static_cast<size_t>(bytes / 8 * kSizes[info.type]));
      weir_tensor tensor{};
      tensor.data = memories.back().data();
      tensor.bytes = tensor.capacity = memories.back().size();
      tensor.info = info;
      tensors.push_back(tensor);
    }
    frame.struct_size = sizeof frame;
    frame.n_tensors = static_cast<uint32_t>(tensors.size());
    frame.tensors = tensors.data();
  }
};

}  // namespace

// LeakSanitizer of clang 14 sometimes crashes when it scans LuaJIT's memory.
extern "C" __attribute__((visibility("default"))) int __lsan_is_turned_off() {
  return 1;
}

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  require(weir::accept_host(&weir::infer::host()), "the host is of this version");
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput input(data, size);
  const std::string script = make_script(&input);
  const char* const path = script.c_str();
  weir_open request{};
  request.struct_size = sizeof request;
  request.n_models = 1;
  request.paths = &path;
  const weir_option sandbox{"Sandbox", "true"};
  request.options = &sandbox;
  request.n_options = 1;
  const auto model = LuaModel::open(request);
  if (!model) {
    require(!model.error().what.empty(), "an error has a text");
    return 0;
  }
  for (const auto* list : {&(*model)->inputs(), &(*model)->outputs()})
    for (const auto& info : *list) {
      require(info.type < WEIR_TYPE_END && info.rank <= WEIR_RANK_LIMIT, "a tensor is described");
      for (uint32_t i = 0; i < info.rank; ++i) require(info.shape[i] > 0, "an extent is above 0");
    }
  auto runner = LuaRunner::create(**model, {});
  if (!runner) return 0;
  Frame in((*model)->inputs()), out((*model)->outputs());
  (void)(*runner)->invoke(in.frame, out.frame);
  return 0;
}
