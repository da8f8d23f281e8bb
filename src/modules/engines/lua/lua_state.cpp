// Calls Lua. Code that may raise a Lua error runs in a protected call, in functions that own
// nothing, because the error leaves them by longjmp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lua/lua_state.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <mutex>

#include "environment.hpp"
#include "lua/prelude.hpp"
#include "tensor_check.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

constexpr float half_to_float(uint16_t half) noexcept {
  const uint32_t sign = static_cast<uint32_t>(half & 0x8000) << 16;
  const uint32_t exponent = (half >> 10) & 0x1F, fraction = half & 0x3FF;
  if (exponent == 31) return std::bit_cast<float>(sign | 0x7F800000 | fraction << 13);
  if (exponent > 0) return std::bit_cast<float>(sign | (exponent + 112) << 23 | fraction << 13);
  const float small = static_cast<float>(fraction) * 0x1p-24f;  // subnormal
  return sign ? -small : small;
}

// Rounds to nearest, ties to even. Magnitudes that round above 65504 become infinity; NaN stays
// NaN.
constexpr uint16_t float_to_half(float value) noexcept {
  const uint32_t bits = std::bit_cast<uint32_t>(value);
  const auto sign = static_cast<uint16_t>(bits >> 16 & 0x8000);
  const uint32_t magnitude = bits & 0x7FFFFFFF;
  if (magnitude > 0x7F800000) return sign | 0x7E00;
  if (magnitude >= 0x47800000) return sign | 0x7C00;  // 65536 and above
  if (magnitude < 0x38800000) {                       // below 2^-14: steps of 2^-24
    // The last fraction bit of the sum is worth 2^-24, so the addition rounds.
    const float sum = std::bit_cast<float>(magnitude) + 0.5f;
    return sign | static_cast<uint16_t>(std::bit_cast<uint32_t>(sum) - 0x3F000000);
  }
  const uint32_t rebased = magnitude - (112u << 23);
  return sign | static_cast<uint16_t>((rebased + 0xFFF + (rebased >> 13 & 1)) >> 13);
}

// Set once, before the first state is created: the process has one LuaApi. Functions that Lua calls
// have no other access to it.
const LuaApi* lua = nullptr;
std::once_flag lua_is_set;

constexpr ptrdiff_t kMebibyte = 1 << 20;
// Collector work per allocation while a cycle runs, in percent of 1 KiB. With LuaJIT's default of
// 200, a script that builds long strings reaches the limit before the first cycle ends.
constexpr int kCollectorStep = 10000;

// ---- Functions that the script's side calls --------------------------------------------------

float read_half(uint16_t half) noexcept {
  return half_to_float(half);
}
uint16_t write_half(float value) noexcept {
  return float_to_half(value);
}
// Returns 0 when memory runs out.
int unshare(void* given) noexcept {
  auto& slot = *static_cast<TensorSlot*>(given);
  try {
    slot.own.resize(slot.bytes);
  } catch (const std::exception&) {
    return 0;
  }
  if (slot.bytes > 0) std::memcpy(slot.own.data(), slot.data, slot.bytes);
  slot.data = slot.own.data();
  slot.shared = 0;
  return 1;
}

int add_traceback(lua_State* state) {
  const bool text = lua->lua_type(state, 1) == kLuaString;
  if (!text) lua->lua_pushstring(state, "the error is not text");
  lua->luaL_traceback(state, state, lua->lua_tolstring(state, text ? 1 : -1, nullptr), 1);
  return 1;
}

template <class Function>
void push_address(lua_State* state, Function* function) {
  lua->lua_pushlightuserdata(state, reinterpret_cast<void*>(function));
}

void open_library(lua_State* state, const char* name, LuaFunction open, int results) {
  lua->lua_pushcclosure(state, open, 0);
  lua->lua_pushstring(state, name);
  lua->lua_call(state, 1, results);
}

// ---- Messages --------------------------------------------------------------------------------

// Lines of our prelude, and the frame at the bottom of every script's traceback.
bool is_uninformative(std::string_view line) {
  return line.starts_with("\tweir:") || line.starts_with("\t[C]: in ?");
}

std::string for_people(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size());
    const auto line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (is_uninformative(line)) continue;
    out += out.empty() ? "" : "\n    ";
    out += line.starts_with('\t') ? "  " + std::string(line.substr(1)) : std::string(line);
  }
  constexpr std::string_view kEmptyTrace = "\n    stack traceback:";
  if (out.ends_with(kEmptyTrace)) out.resize(out.size() - kEmptyTrace.size());
  return out;
}

// The fix, if the message suggests one.
std::string fix_for(const std::string& message, const LuaOptions& options, int status) {
  if (status == kLuaOutOfMemory || message.find("not enough memory") != message.npos)
    return "custom=MemoryLimit:" + std::to_string(options.memory_limit * 2);
  for (const auto& library : withheld_libraries()) {
    const bool loads = library == "package" && message.find("global 'require'") != message.npos;
    if (!options.opens(library.c_str()) &&
        (loads || message.find("global '" + library + "' (a nil value)") != message.npos))
      return "custom=Libraries:" + library + ", if you trust the script";
  }
  return "";
}

bool is_byte_code(std::string_view text) {
  return text.starts_with('\x1B');
}

Error byte_code(const std::string& name) {
  return {.code = Code::MODEL_INVALID,
          .what = "Lua byte code is not run, because it can bypass the sandbox",
          .offered = name,
          .needed = "the script's source text",
          .fix = "model=SCRIPT.lua"};
}

}  // namespace

// ---- The state -------------------------------------------------------------------------------

void* LuaState::within_budget(void* given, void* block, size_t old_bytes, size_t bytes) {
  auto& budget = *static_cast<Budget*>(given);
  const ptrdiff_t more = static_cast<ptrdiff_t>(bytes) - static_cast<ptrdiff_t>(old_bytes);
  if (more > 0 && budget.used + more > budget.limit) return nullptr;
  void* result = budget.allocate(budget.data, block, old_bytes, bytes);
  if (result || bytes == 0) budget.used += more;
  return result;
}

Result<std::unique_ptr<LuaState>> LuaState::create(const LuaApi& api, const LuaOptions& options) {
  std::call_once(lua_is_set, [&] { lua = &api; });
  std::unique_ptr<LuaState> out(new LuaState(api, options));
  out->state_ = api.luaL_newstate();
  if (!out->state_)
    return Error{.code = Code::OUT_OF_MEMORY, .what = "LuaJIT has no memory for another script"};
  auto& budget = out->budget_;
  budget.limit = static_cast<ptrdiff_t>(options.memory_limit) * kMebibyte;
  budget.allocate = api.lua_getallocf(out->state_, &budget.data);
  api.lua_setallocf(out->state_, within_budget, &budget);
  api.lua_gc(out->state_, kLuaSetStep, kCollectorStep);
  if (const int status = api.lua_cpcall(out->state_, prepare, out.get()))
    return out->failure(Code::INTERNAL, "a script cannot be loaded", status);
  return out;
}

LuaState::~LuaState() {
  if (!state_) return;
  // lua_close() with the original allocator frees all memory at once.
  api_.lua_setallocf(state_, budget_.allocate, budget_.data);
  api_.lua_close(state_);
}

int LuaState::prepare(lua_State* state) {
  auto& self = *static_cast<LuaState*>(lua->lua_touserdata(state, 1));
  const struct {
    const char* name;
    LuaFunction open;
    bool given;
  } libraries[] = {
      {"", lua->luaopen_base, true},
      {"table", lua->luaopen_table, true},
      {"string", lua->luaopen_string, true},
      {"math", lua->luaopen_math, true},
      {"bit", lua->luaopen_bit, true},
      {"jit", lua->luaopen_jit, true},  // starts the JIT compiler
      {"io", lua->luaopen_io, self.options_.opens("io")},
      {"os", lua->luaopen_os, self.options_.opens("os")},
      {"debug", lua->luaopen_debug, self.options_.opens("debug")},
      {"package", lua->luaopen_package, self.options_.opens("package")},
  };
  for (const auto& library : libraries)
    if (library.given) open_library(state, library.name, library.open, 0);
  lua->luaL_loadbufferx(state, kPrelude, std::strlen(kPrelude), "=weir", "t");
  open_library(state, "ffi", lua->luaopen_ffi, 1);
  lua->lua_pushvalue(state, -1);  // keeps its tables, including metatypes, from being collected
  lua->luaL_ref(state, kLuaRegistry);
  if (self.options_.opens("ffi")) {
    lua->lua_pushvalue(state, -1);
    lua->lua_setfield(state, kLuaGlobals, "ffi");
  }
  lua->lua_getfield(state, kLuaRegistry, "_LOADED");  // the modules that require() finds
  for (const char* name : {"ffi", "jit", "jit.util", "jit.opt"}) {
    if (self.options_.opens(std::strncmp(name, "jit", 3) == 0 ? "jit" : name)) continue;
    lua->lua_pushnil(state);
    lua->lua_setfield(state, -2, name);
  }
  lua->lua_settop(state, -2);
  if (!self.options_.opens("jit")) {
    lua->lua_pushnil(state);
    lua->lua_setfield(state, kLuaGlobals, "jit");
  }
  lua->lua_pushvalue(state, kLuaGlobals);
  push_address(state, read_half);
  push_address(state, write_half);
  push_address(state, unshare);
  lua->lua_pushboolean(state, self.options_.sandbox ? 1 : 0);
  lua->lua_call(state, 6, 3);
  self.invoke_ = lua->luaL_ref(state, kLuaRegistry);
  self.bind_ = lua->luaL_ref(state, kLuaRegistry);
  self.describe_ = lua->luaL_ref(state, kLuaRegistry);
  lua->lua_pushcclosure(state, add_traceback, 0);
  self.traceback_ = lua->luaL_ref(state, kLuaRegistry);
  return 0;
}

Error LuaState::failure(Code code, std::string what, int status) {
  size_t size = 0;
  const char* text =
      api_.lua_type(state_, -1) == kLuaString ? api_.lua_tolstring(state_, -1, &size) : nullptr;
  const std::string message = text ? for_people({text, size}) : "an error that is not text";
  api_.lua_settop(state_, 0);
  return {.code = code,
          .what = std::move(what),
          .offered = message,
          .fix = fix_for(message, options_, status)};
}

Status LuaState::search_in(const std::string& folder) {
  constexpr std::string_view kText = R"lua(
    local folder, keeps_path, keeps_cpath = ...
    if not package then return end
    local function searched(path, extension)
      local out = {folder ~= '' and folder .. '/?' .. extension or nil}
      for part in path:gmatch('[^;]+') do
        if part:sub(1, 2) ~= './' then out[#out + 1] = part end
      end
      return table.concat(out, ';')
    end
    if not keeps_path then package.path = searched(package.path, '.lua') end
    if not keeps_cpath then package.cpath = searched(package.cpath, '.so') end)lua";
  if (const int status = api_.luaL_loadbufferx(state_, kText.data(), kText.size(), "=weir", "t"))
    return failure(Code::INTERNAL, "the search path of scripts cannot be set", status);
  // Both characters have a meaning in a search path.
  const bool can_be_searched = folder.find_first_of(";?") == std::string::npos;
  api_.lua_pushstring(state_, can_be_searched ? folder.c_str() : "");
  for (const char* variable : {"LUA_PATH", "LUA_CPATH"})
    api_.lua_pushboolean(state_, environment_variable(variable) ? 1 : 0);
  if (const int status = api_.lua_pcall(state_, 3, 0, 0))
    return failure(Code::INTERNAL, "the search path of scripts cannot be set", status);
  return ok();
}

Status LuaState::run(std::string_view text, const std::string& name) {
  if (is_byte_code(text)) return byte_code(name);
  const std::string chunk = "@" + name;
  api_.lua_rawgeti(state_, kLuaRegistry, traceback_);
  if (const int status =
          api_.luaL_loadbufferx(state_, text.data(), text.size(), chunk.c_str(), "t"))
    return failure(Code::MODEL_INVALID, "the script is not valid Lua", status);
  if (const int status = api_.lua_pcall(state_, 0, 0, 1))
    return failure(Code::MODEL_INVALID, "the script failed before the first frame", status);
  api_.lua_settop(state_, 0);
  return ok();
}

Result<ScriptTensors> LuaState::describe() {
  api_.lua_rawgeti(state_, kLuaRegistry, describe_);
  if (const int status = api_.lua_pcall(state_, 0, 4, 0))
    return failure(Code::MODEL_INVALID, "the tables of the script cannot be read", status);
  if (api_.lua_type(state_, 1) != kLuaTable) {
    const auto part = [this](int index) {
      const char* text = api_.lua_type(state_, index) == kLuaString
                             ? api_.lua_tolstring(state_, index, nullptr)
                             : nullptr;
      return std::string(text ? text : "");
    };
    Error error{
        .code = Code::MODEL_INVALID, .what = part(2), .offered = part(3), .needed = part(4)};
    api_.lua_settop(state_, 0);
    return error;
  }
  auto tensors = read_flat_list();
  api_.lua_settop(state_, 0);
  return tensors;
}

Result<ScriptTensors> LuaState::read_flat_list() {
  int at = 0;
  bool good = true;
  const auto next = [&](int64_t min, int64_t max) {
    api_.lua_rawgeti(state_, 1, ++at);
    const double number = api_.lua_tonumber(state_, -1);
    api_.lua_settop(state_, -2);
    good = good && number >= static_cast<double>(min) && number <= static_cast<double>(max) &&
           number == std::floor(number);
    return good ? static_cast<int64_t>(number) : min;
  };
  ScriptTensors out;
  for (auto* list : {&out.inputs, &out.outputs}) {
    list->resize(static_cast<size_t>(next(1, WEIR_TENSOR_LIMIT)));
    for (auto& info : *list) {
      info = open_tensor_info();
      info.type = static_cast<uint32_t>(next(0, WEIR_TYPE_END - 1));
      info.rank = static_cast<uint32_t>(next(1, WEIR_RANK_LIMIT));
      for (uint32_t i = 0; i < info.rank; ++i) info.shape[i] = next(1, INT32_MAX);
      good = good && tensor_bytes(info).has_value();
    }
  }
  if (!good)
    return Error{.code = Code::MODEL_INVALID,
                 .what = "the tables of the script contain a number that is out of range",
                 .offered = {},
                 .needed = "integers in range",
                 .difference = {},
                 .fix = {}};
  return out;
}

int LuaState::bind_slots(lua_State* state) {
  const auto& given = *static_cast<const Binding*>(lua->lua_touserdata(state, 1));
  lua->lua_rawgeti(state, kLuaRegistry, given.function);
  for (auto* slots : {given.inputs, given.outputs}) {
    lua->lua_pushlightuserdata(state, slots->data());
    lua->lua_pushnumber(state, static_cast<double>(slots->size()));
  }
  lua->lua_pushnumber(state, sizeof(TensorSlot));
  lua->lua_call(state, 5, 0);
  return 0;
}

Status LuaState::bind(std::vector<TensorSlot>* inputs, std::vector<TensorSlot>* outputs) {
  Binding binding{bind_, inputs, outputs};
  if (const int status = api_.lua_cpcall(state_, bind_slots, &binding))
    return failure(Code::INTERNAL, "the tensors of a script cannot be created", status);
  return ok();
}

Result<bool> LuaState::invoke() {
  api_.lua_rawgeti(state_, kLuaRegistry, traceback_);
  api_.lua_rawgeti(state_, kLuaRegistry, invoke_);
  if (const int status = api_.lua_pcall(state_, 0, 1, 1))
    return failure(Code::INVOKE_FAILED, "the script failed on a frame", status);
  const bool is_dropped =
      api_.lua_type(state_, -1) == kLuaBoolean && api_.lua_toboolean(state_, -1) == 0;
  api_.lua_settop(state_, 0);
  return !is_dropped;
}

uint64_t LuaState::bytes() const {
  return static_cast<uint64_t>(api_.lua_gc(state_, kLuaCountKibibytes, 0)) * 1024 +
         static_cast<uint64_t>(api_.lua_gc(state_, kLuaCountRest, 0));
}

}  // namespace weir::engine
