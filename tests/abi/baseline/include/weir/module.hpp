// Helpers for modules in C++: the host, conversion of exceptions to errors of the C ABI, options,
// and tensor descriptions. Header-only: a module links nothing of Weir. See engine.hpp and
// decoder.hpp.
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

// Throw it anywhere in a module; the host reports the error. `what` is required.
class Failure : public std::exception {
 public:
  explicit Failure(Error error) : error_(std::move(error)), text_(error_.message()) {}
  const Error& error() const noexcept { return error_; }
  const char* what() const noexcept override { return text_.c_str(); }

 private:
  Error error_;
  std::string text_;
};

// Returns the value or throws Failure with the error.
template <class T>
T value_or_throw(Result<T> result) {
  if (!result) throw Failure(result.error());
  return *std::move(result);
}

// The host's table; weir_module_entry sets it before any other code of the module runs.
inline const weir_host* module_host = nullptr;

// Stores the host's table, for weir_module_entry. Returns false, with the reason in the host's log,
// when this module cannot work with the host; the entry then returns NULL.
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

// Fills the caller's weir_error through `host`; returns the negated code.
inline int fail(const weir_host& host, weir_error* to, const Error& error) {
  const auto text = [](const std::string& part) { return part.empty() ? nullptr : part.c_str(); };
  return host.fail(to, static_cast<int>(error.code), text(error.what), text(error.offered),
                   text(error.needed), text(error.difference), text(error.fix));
}
inline int fail(weir_error* to, const Error& error) {
  return fail(*module_host, to, error);
}

// Runs `body`, which returns an ABI return value, a Status, or a Result<bool> that is false for a
// frame without a result, and converts exceptions to errors: no exception may leave the module.
template <class Body>
int guarded(weir_error* to, Body&& body) noexcept {
  // Allocates nothing in the module.
  const auto threw = [to](const char* text) {
    return module_host->fail(to, WEIR_CALLBACK_FAILED, "a class in C++ threw an exception", text,
                             nullptr, nullptr, "throw weir::Failure with a code and a message");
  };
  try {
    if constexpr (std::is_same_v<decltype(body()), Status>) {
      const Status status = body();
      return status ? WEIR_OK : fail(to, status.error());
    } else if constexpr (std::is_same_v<decltype(body()), Result<bool>>) {
      const Result<bool> kept = body();
      if (!kept) return fail(to, kept.error());
      if (!*kept) return WEIR_NO_RESULT;
      return WEIR_OK;
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
    return threw("not derived from std::exception");
  }
}

// The options passed to a module, as keys and values.
class Options {
 public:
  Options(const weir_option* options, uint32_t count) : options_(options, options ? count : 0) {}
  // Returns the last value of `key`; nullopt if it is not set.
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

// Describes a tensor: shape outermost-first, -1 = unknown. `name` is borrowed. Throws Failure for
// more than 16 dimensions.
inline weir_tensor_info tensor_info(const char* name, weir_type type,
                                    std::initializer_list<int64_t> shape) {
  weir_tensor_info info{};
  info.type = type;
  info.name = name;
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  for (const int64_t extent : shape) {
    if (info.rank == WEIR_RANK_LIMIT)
      throw Failure({.code = Code::LIMIT_EXCEEDED,
                     .what = "a tensor has too many dimensions",
                     .offered = name ? name : "",
                     .needed = "at most 16"});
    info.shape[info.rank++] = extent;
  }
  return info;
}

// Allocates `bytes` of host memory for a tensor and sets its info. The receiver of the tensor
// releases the memory. Throws std::bad_alloc or Failure.
inline void allocate(weir_tensor* tensor, const weir_tensor_info& info, size_t bytes) {
  const int result = module_host->allocate(nullptr, WEIR_MEMORY_HOST, bytes, 64, tensor);
  if (result == -WEIR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (result < 0)
    throw Failure({static_cast<Code>(-result), "the host gives no memory for a tensor",
                   std::to_string(bytes) + " bytes", "", "", ""});
  tensor->info = info;
}

// Returns the elements of a dense tensor in host memory.
template <class T>
std::span<T> elements(const weir_tensor& tensor) noexcept {
  return {static_cast<T*>(tensor.data), tensor.bytes / sizeof(T)};
}

// ---- Tensor descriptions ---------------------------------------------------------------------

// Returns dimension `index` counted from the innermost, as in caps; 1 beyond the rank, -1 =
// unknown.
constexpr int64_t dimension(const weir_tensor_info& info, uint32_t index) noexcept {
  if (info.rank > WEIR_RANK_LIMIT) return -1;
  return index < info.rank ? info.shape[info.rank - 1 - index] : 1;
}

// Bytes of one element; 0 for an unknown type.
constexpr size_t element_bytes(uint32_t type) noexcept {
  constexpr uint8_t kBytes[WEIR_TYPE_END] = {4, 4, 2, 2, 1, 1, 8, 4, 8, 8, 2};
  return type < WEIR_TYPE_END ? kBytes[type] : 0;
}

// Returns "float32"; "?" for an unknown type.
constexpr const char* type_name(uint32_t type) noexcept {
  constexpr const char* kNames[WEIR_TYPE_END] = {"int32", "uint32", "int16",   "uint16",
                                                 "int8",  "uint8",  "float64", "float32",
                                                 "int64", "uint64", "float16"};
  return type < WEIR_TYPE_END ? kNames[type] : "?";
}

// Returns "uint8 3:224:224", as in caps, innermost first; ? = unknown.
inline std::string describe(const weir_tensor_info& info) {
  std::string text = type_name(info.type);
  if (info.rank > WEIR_RANK_LIMIT) return text + " ?";
  for (uint32_t i = 0; i < info.rank; ++i) {
    const int64_t extent = dimension(info, i);
    text += (i == 0 ? " " : ":") + (extent < 0 ? "?" : std::to_string(extent));
  }
  return info.rank == 0 ? text + " 1" : text;
}

}  // namespace weir
