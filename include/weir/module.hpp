// What modules in C++ share: the host, errors on their way back through the C ABI, options, and
// words for tensors. Header-only: a module links nothing of Weir. See engine.hpp and decoder.hpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <exception>
#include <initializer_list>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir {

// Throw it anywhere in a module: the host shows the error. Fill `what`, and what else there is.
class Failure : public std::exception {
 public:
  explicit Failure(Error error) : error_(std::move(error)), text_(error_.message()) {}
  const Error& error() const noexcept { return error_; }
  const char* what() const noexcept override { return text_.c_str(); }

 private:
  Error error_;
  std::string text_;
};

// The value, or its error thrown.
template <class T>
T value_or_throw(Result<T> result) {
  if (!result) throw Failure(result.error());
  return *std::move(result);
}

// The host's table; set by weir_module_entry, before anything else of the module runs.
inline const weir_host* module_host = nullptr;

// For weir_module_entry: keeps the host's table. False when this module cannot work with that host,
// with the reason in its log; the entry gives NULL then.
inline bool accept_host(const weir_host* host) noexcept {
  if (!host || host->struct_size < offsetof(weir_host, extension) + sizeof host->extension)
    return false;
  if (host->abi_major != WEIR_ABI_MAJOR) {
    if (host->log)
      host->log(WEIR_LOG_ERROR, "module",
                "the module was built for another major version of Weir's ABI: build it again");
    return false;
  }
  module_host = host;
  return true;
}

// Fills the caller's weir_error through that host; returns what an ABI function returns.
inline int fail(const weir_host& host, weir_error* to, const Error& error) {
  const auto text = [](const std::string& part) { return part.empty() ? nullptr : part.c_str(); };
  return host.fail(to, static_cast<int>(error.code), text(error.what), text(error.offered),
                   text(error.needed), text(error.difference), text(error.fix));
}
inline int fail(weir_error* to, const Error& error) {
  return fail(*module_host, to, error);
}

// Runs `body`, which returns what an ABI function returns, or a Status; what it throws becomes an
// error: nothing of C++ leaves the module.
template <class Body>
int guarded(weir_error* to, Body&& body) noexcept {
  // These allocate nothing here.
  const auto threw = [to](const char* text) {
    return module_host->fail(to, WEIR_CALLBACK_FAILED, "a class in C++ threw an exception", text,
                             nullptr, nullptr, "throw weir::Failure, which has words of its own");
  };
  try {
    if constexpr (std::is_same_v<decltype(body()), Status>) {
      const Status status = body();
      return status ? WEIR_OK : fail(to, status.error());
    } else {
      return body();
    }
  } catch (const Failure& failure) {
    return fail(to, failure.error());
  } catch (const std::bad_alloc&) {
    return module_host->fail(to, WEIR_OUT_OF_MEMORY, "memory ran out in a module", nullptr, nullptr,
                             nullptr, nullptr);
  } catch (const std::exception& e) {
    return threw(e.what());
  } catch (...) {
    return threw("of no type that std::exception knows");
  }
}

// The options given to a module: keys and values.
class Options {
 public:
  Options(const weir_option* options, uint32_t count) : options_(options, options ? count : 0) {}
  // The last value of `key`; nullopt when it was not given.
  std::optional<std::string_view> get(std::string_view key) const {
    std::optional<std::string_view> value;
    for (const auto& option : options_)
      if (option.key && key == option.key) value = option.value ? option.value : "";
    return value;
  }
  std::span<const weir_option> all() const noexcept { return options_; }

 private:
  std::span<const weir_option> options_;
};

// ---- Tensors ---------------------------------------------------------------------------------

// Its description: shape outermost-first, -1 = unknown. `name` is borrowed.
inline weir_tensor_info tensor_info(const char* name, weir_type type,
                                    std::initializer_list<int64_t> shape) {
  weir_tensor_info info{};
  info.type = type;
  info.name = name;
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  for (const int64_t extent : shape) {
    if (info.rank == WEIR_RANK_LIMIT)
      throw Failure({Code::LIMIT_EXCEEDED, "a tensor has too many dimensions", name ? name : "",
                     "at most 16", "", ""});
    info.shape[info.rank++] = extent;
  }
  return info;
}

// Memory of the host for a tensor that has none: `bytes` of it, described as `info` says. Whoever
// takes the tensor releases it.
inline void allocate(weir_tensor* tensor, const weir_tensor_info& info, size_t bytes) {
  const int result = module_host->allocate(nullptr, WEIR_MEMORY_HOST, bytes, 64, tensor);
  if (result == -WEIR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (result < 0)
    throw Failure({static_cast<Code>(-result), "the host gives no memory for a tensor",
                   std::to_string(bytes) + " bytes", "", "", ""});
  tensor->info = info;
}

// The elements of a tensor in host memory.
template <class T>
std::span<T> elements(const weir_tensor& tensor) noexcept {
  return {static_cast<T*>(tensor.data), tensor.bytes / sizeof(T)};
}

// ---- Words for tensors -----------------------------------------------------------------------

// Dimension `index` counted from the innermost one, as caps count; 1 beyond the rank, -1 = unknown.
constexpr int64_t dimension(const weir_tensor_info& info, uint32_t index) noexcept {
  if (info.rank > WEIR_RANK_LIMIT) return -1;
  return index < info.rank ? info.shape[info.rank - 1 - index] : 1;
}

// Bytes of one element; 0 when the type is not known.
constexpr size_t element_bytes(uint32_t type) noexcept {
  constexpr uint8_t kBytes[WEIR_TYPE_END] = {4, 4, 2, 2, 1, 1, 8, 4, 8, 8, 2};
  return type < WEIR_TYPE_END ? kBytes[type] : 0;
}

// "uint8 3:224:224", as caps write it: innermost first; ? = unknown.
inline std::string describe(const weir_tensor_info& info) {
  constexpr const char* kNames[WEIR_TYPE_END] = {"int32", "uint32", "int16",   "uint16",
                                                 "int8",  "uint8",  "float64", "float32",
                                                 "int64", "uint64", "float16"};
  std::string text = info.type < WEIR_TYPE_END ? kNames[info.type] : "?";
  if (info.rank > WEIR_RANK_LIMIT) return text + " ?";
  for (uint32_t i = 0; i < info.rank; ++i) {
    const int64_t extent = dimension(info, i);
    text += (i == 0 ? " " : ":") + (extent < 0 ? "?" : std::to_string(extent));
  }
  return info.rank == 0 ? text + " 1" : text;
}

}  // namespace weir
