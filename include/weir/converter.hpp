// An external converter in C++: write a class, export it with one line and build it as
// libweir-converter-NAME.so.
//
//   class Lines {
//    public:
//     explicit Lines(const weir::Options& options);
//     std::vector<weir_tensor_info> configure(std::string_view caps);
//     bool convert(const weir_frame& frame, weir::ConverterOutput& output);
//     void reset() noexcept;
//     std::optional<std::pair<int32_t, int32_t>> rate() noexcept;
//     bool is_flexible() noexcept;
//   };
//   WEIR_CONVERTER(Lines, "lines", "", "text/x-lines, framerate=(fraction)[ 0/1, 2147483647/1 ]",
//                  "[]")
//
// The host calls configure before the first frame and when the stream's caps change. It returns the
// tensors of each frame, or none when they are unknown before the first frame. The stream keeps the
// frame rate of its caps. The frame holds one uint8 tensor for each memory of the buffer, readable
// until convert returns. convert adds the tensors of the frame; when they differ from the previous
// ones, the stream's caps change. It returns false to drop the frame. The optional reset runs after
// a flush or a seek and discards what was kept of earlier frames. The optional rate returns the
// frame rate that the last frame carried, for formats whose frames carry one. The optional
// is_flexible returns whether the tensors of the last frame are flexible, each with its 128-byte
// header. The other functions may throw weir::Failure or any exception, which
// becomes an error on the bus. An object is used by one thread at a time. Shapes are
// outermost-first (abi.h, rule C).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <initializer_list>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "weir/module.hpp"

namespace weir {

// Describes a dense tensor of at most 16 dimensions, outermost first, each at least 1. Throws
// Failure (LIMIT_EXCEEDED) for more dimensions.
inline weir_tensor_info dense_tensor(weir_type type, std::initializer_list<int64_t> shape) {
  if (shape.size() > WEIR_RANK_LIMIT)
    throw Failure({.code = Code::LIMIT_EXCEEDED,
                   .what = "a tensor has more than 16 dimensions",
                   .offered = std::to_string(shape.size()),
                   .needed = "at most 16"});
  weir_tensor_info info{};
  info.type = type;
  info.rank = static_cast<uint32_t>(shape.size());
  std::copy(shape.begin(), shape.end(), info.shape);
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

// Receives the tensors of one frame from a converter.
class ConverterOutput {
 public:
  ConverterOutput(weir_frame* frame, void* host_ctx)
      : frame_(frame), room_(frame->n_tensors), host_ctx_(host_ctx) {
    frame_->n_tensors = 0;
  }

  // Appends a tensor and returns its memory: uninitialised, aligned to 64 bytes, valid until
  // convert returns. `header_bytes` of a flexible tensor come before its payload. Throws Failure
  // (LIMIT_EXCEEDED) when the description is invalid or the frame is full, std::bad_alloc when out
  // of memory.
  std::span<std::byte> add(const weir_tensor_info& info, uint64_t header_bytes = 0) {
    uint64_t bytes = element_bytes(info.type);
    for (uint32_t i = 0; i < info.rank && i < WEIR_RANK_LIMIT; ++i)
      if (info.shape[i] < 1 ||
          __builtin_mul_overflow(bytes, static_cast<uint64_t>(info.shape[i]), &bytes))
        bytes = 0;
    if (bytes == 0 || bytes > INT64_MAX || info.rank > WEIR_RANK_LIMIT)
      throw Failure({.code = Code::LIMIT_EXCEEDED,
                     .what = "a converter describes an invalid tensor",
                     .offered = describe(info),
                     .needed = "a type, and dimensions of at least 1"});
    bytes += header_bytes;
    weir_tensor& tensor = next();
    if (module_host->allocate(host_ctx_, WEIR_MEMORY_HOST, bytes, 64, &tensor) < 0)
      throw std::bad_alloc();
    describe_as(info, &tensor);
    return {static_cast<std::byte*>(tensor.data), bytes};
  }
  // Appends a tensor whose bytes, with its header if it is flexible, are a part of one input of
  // this frame. The host shares the memory where it can, otherwise it copies the bytes. Throws
  // Failure (LIMIT_EXCEEDED) when the frame is full.
  void share(const weir_tensor_info& info, std::span<const std::byte> part) {
    weir_tensor& tensor = next();
    tensor = {};
    tensor.data = const_cast<std::byte*>(part.data());
    tensor.bytes = tensor.capacity = part.size();
    tensor.flags = WEIR_TENSOR_READONLY | WEIR_TENSOR_ALIASES_INPUT;
    tensor.fence_fd = -1;
    describe_as(info, &tensor);
  }
  // Sets the PTS and duration of the output in ns, -1 = none. They default to those of the input.
  void set_time(int64_t pts, int64_t duration) noexcept {
    frame_->pts = pts;
    frame_->duration = duration;
  }

 private:
  weir_tensor& next() {
    if (frame_->n_tensors == room_)
      throw Failure({.code = Code::LIMIT_EXCEEDED,
                     .what = "a frame has too many tensors",
                     .offered = std::to_string(room_ + 1),
                     .needed = "at most " + std::to_string(room_)});
    return frame_->tensors[frame_->n_tensors];
  }
  void describe_as(const weir_tensor_info& info, weir_tensor* tensor) {
    tensor->info = info;
    tensor->info.name = nullptr;
    ++frame_->n_tensors;
  }

  weir_frame* frame_;
  uint32_t room_;
  void* host_ctx_;
};

// Returns the table of the extension weir.converter-rate/1 for the class `Opened::converter`.
template <class Opened>
const weir_converter_rate* rate_table() {
  static const weir_converter_rate table{
      sizeof(weir_converter_rate), [](weir_converter* handle, int32_t* n, int32_t* d) {
        const auto rate = reinterpret_cast<Opened*>(handle)->converter.rate();
        if (!rate) return 0;
        *n = rate->first;
        *d = rate->second;
        return 1;
      }};
  return &table;
}

// Returns the table of the extension weir.converter-stream/1 for the class `Opened::converter`.
template <class Opened>
const weir_converter_stream* flexible_table() {
  static const weir_converter_stream table{
      sizeof(weir_converter_stream), [](weir_converter* handle) {
        return reinterpret_cast<Opened*>(handle)->converter.is_flexible() ? 1 : 0;
      }};
  return &table;
}

// Returns the extensions of the class `Opened::converter`: the functions that it has.
template <class Opened>
const void* converter_extension(std::string_view id) {
  using Converter = decltype(Opened::converter);
  if constexpr (requires(Converter & converter) { converter.rate(); }) {
    static_assert(noexcept(std::declval<Converter&>().rate()), "rate must not fail");
    if (id == WEIR_CONVERTER_RATE) return rate_table<Opened>();
  }
  if constexpr (requires(Converter & converter) { converter.is_flexible(); }) {
    static_assert(noexcept(std::declval<Converter&>().is_flexible()), "is_flexible must not fail");
    if (id == WEIR_CONVERTER_STREAM) return flexible_table<Opened>();
  }
  return nullptr;
}

// Makes the C table for the class `Converter`.
template <class Converter>
weir_converter_type converter_table(const char* name, const char* aliases, const char* caps,
                                    const char* options_json) {
  struct Opened {
    Converter converter;
    void* host_ctx;
  };
  weir_converter_type table{};
  table.struct_size = sizeof table;
  table.abi_major = WEIR_ABI_MAJOR;
  table.abi_minor = WEIR_ABI_MINOR;
  table.name = name;
  table.aliases = aliases;
  table.caps = caps;
  table.options_json = options_json;
  table.open = [](const weir_option* options, uint32_t count, void* host_ctx, weir_converter** out,
                  weir_error* error) {
    *out = nullptr;
    return guarded(error, [&] {
      std::unique_ptr<Opened> opened(new Opened{Converter(Options(options, count)), host_ctx});
      *out = reinterpret_cast<weir_converter*>(opened.release());
      return WEIR_OK;
    });
  };
  table.close = [](weir_converter* handle) { delete reinterpret_cast<Opened*>(handle); };
  table.configure = [](weir_converter* handle, const char* caps_text, weir_tensor_info* out,
                       uint32_t* count, weir_error* error) {
    return guarded(error, [&] {
      const std::vector<weir_tensor_info> infos =
          reinterpret_cast<Opened*>(handle)->converter.configure(caps_text);
      if (infos.size() > *count)
        throw Failure({.code = Code::LIMIT_EXCEEDED,
                       .what = "a frame has too many tensors",
                       .offered = std::to_string(infos.size()),
                       .needed = "at most " + std::to_string(*count)});
      std::copy(infos.begin(), infos.end(), out);
      *count = static_cast<uint32_t>(infos.size());
      return WEIR_OK;
    });
  };
  table.convert = [](weir_converter* handle, const weir_frame* in, weir_frame* out,
                     weir_error* error) {
    return guarded(error, [&] {
      auto* opened = reinterpret_cast<Opened*>(handle);
      ConverterOutput output(out, opened->host_ctx);
      return opened->converter.convert(*in, output) ? 0 : 1;
    });
  };
  if constexpr (requires(Converter & converter) { converter.reset(); }) {
    static_assert(noexcept(std::declval<Converter&>().reset()), "reset must not fail");
    table.reset = [](weir_converter* handle) {
      reinterpret_cast<Opened*>(handle)->converter.reset();
    };
  }
  table.extension = [](const char* id) { return converter_extension<Opened>(id); };
  return table;
}

}  // namespace weir

// Exports the class `Converter` under `name` and `aliases` (comma-separated). `caps`: accepted
// input as GStreamer caps text; `options_json`: its options (abi.h).
#define WEIR_CONVERTER(Converter, name, aliases, caps, options_json)                      \
  extern "C" __attribute__((visibility("default"))) const weir_module* weir_module_entry( \
      const weir_host* host) {                                                            \
    if (!::weir::accept_host(host)) return nullptr;                                       \
    static const weir_converter_type table =                                              \
        ::weir::converter_table<Converter>(name, aliases, caps, options_json);            \
    static const weir_converter_type* const tables[] = {&table, nullptr};                 \
    static const weir_module module{sizeof(weir_module),                                  \
                                    WEIR_ABI_MAJOR,                                       \
                                    WEIR_ABI_MINOR,                                       \
                                    nullptr,                                              \
                                    nullptr,                                              \
                                    tables,                                               \
                                    nullptr,                                              \
                                    nullptr};                                             \
    return &module;                                                                       \
  }
