// An external converter in C++: write a class, export it with one line, build it as
// libweir-converter-NAME.so.
//
//   class Lines {
//    public:
//     explicit Lines(const weir::Options& options);
//     std::vector<weir_tensor_info> configure(std::string_view caps);
//     bool convert(const weir_frame& frame, weir::ConverterOutput& output);
//     void reset() noexcept;
//     std::optional<std::pair<int32_t, int32_t>> rate() noexcept;
//   };
//   WEIR_CONVERTER(Lines, "lines", "", "text/x-lines, framerate=(fraction)[ 0/1, 2147483647/1 ]",
//                  "[]")
//
// configure comes before the first frame and when the stream's caps change: the tensors of each
// frame, or none when they are not known before the first. The frame rate of the caps stays that of
// the stream. The frame holds one uint8 tensor for each memory of the buffer, readable until
// convert returns. convert adds the tensors of this frame; they may differ from those before, the
// stream's caps change then. It returns false to drop the frame. reset may be left out: it forgets
// what was kept of earlier frames, for a flush or a seek came. rate may be left out too: the frame
// rate that the last frame said, where frames say their own. Each other function may throw
// weir::Failure, or anything: it becomes an error on the bus. One object is used by one thread at a
// time. Shapes are outermost-first (abi.h, rule C).
#pragma once
#include <algorithm>
#include <initializer_list>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "weir/converter_rate.h"
#include "weir/module.hpp"

namespace weir {

// The description of a dense tensor; at most 16 dimensions, outermost first, each at least 1.
inline weir_tensor_info dense_tensor(weir_type type, std::initializer_list<int64_t> shape) {
  if (shape.size() > WEIR_RANK_LIMIT)
    throw Failure({Code::LIMIT_EXCEEDED, "a tensor has more than 16 dimensions",
                   std::to_string(shape.size()), "at most 16", "", ""});
  weir_tensor_info info{};
  info.type = type;
  info.rank = static_cast<uint32_t>(shape.size());
  std::copy(shape.begin(), shape.end(), info.shape);
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

// Where a converter puts the tensors of one frame.
class ConverterOutput {
 public:
  ConverterOutput(weir_frame* frame, void* host_ctx)
      : frame_(frame), room_(frame->n_tensors), host_ctx_(host_ctx) {
    frame_->n_tensors = 0;
  }

  // Appends a tensor and gives its memory: not zeroed, aligned to 64 bytes, valid until convert
  // returns. Throws Failure when the description is not of a tensor or there is no room,
  // std::bad_alloc when memory ran out.
  std::span<std::byte> add(const weir_tensor_info& info) {
    if (frame_->n_tensors == room_)
      throw Failure({Code::LIMIT_EXCEEDED, "a frame has too many tensors",
                     std::to_string(room_ + 1), "at most " + std::to_string(room_), "", ""});
    uint64_t bytes = element_bytes(info.type);
    for (uint32_t i = 0; i < info.rank && i < WEIR_RANK_LIMIT; ++i)
      if (info.shape[i] < 1 ||
          __builtin_mul_overflow(bytes, static_cast<uint64_t>(info.shape[i]), &bytes))
        bytes = 0;
    if (bytes == 0 || bytes > INT64_MAX || info.rank > WEIR_RANK_LIMIT)
      throw Failure({Code::LIMIT_EXCEEDED, "a converter describes a tensor that cannot be",
                     describe(info), "a type, and dimensions of at least 1", "", ""});
    weir_tensor& tensor = frame_->tensors[frame_->n_tensors];
    if (module_host->allocate(host_ctx_, WEIR_MEMORY_HOST, bytes, 64, &tensor) < 0)
      throw std::bad_alloc();
    tensor.info = info;
    tensor.info.name = nullptr;
    ++frame_->n_tensors;
    return {static_cast<std::byte*>(tensor.data), bytes};
  }
  // Nanoseconds of running time, -1 = none; without a call the output has the input's.
  void set_time(int64_t pts, int64_t duration) noexcept {
    frame_->pts = pts;
    frame_->duration = duration;
  }

 private:
  weir_frame* frame_;
  uint32_t room_;
  void* host_ctx_;
};

// The table of the extension weir.converter-rate/1 over the class `Opened::converter`.
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

// The C table over the class `Converter`.
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
        throw Failure({Code::LIMIT_EXCEEDED, "a frame has too many tensors",
                       std::to_string(infos.size()), "at most " + std::to_string(*count), "", ""});
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
    static_assert(noexcept(std::declval<Converter&>().reset()), "reset has no way to fail");
    table.reset = [](weir_converter* handle) {
      reinterpret_cast<Opened*>(handle)->converter.reset();
    };
  }
  if constexpr (requires(Converter & converter) { converter.rate(); }) {
    static_assert(noexcept(std::declval<Converter&>().rate()), "rate has no way to fail");
    table.extension = [](const char* id) -> const void* {
      return std::string_view(id) == WEIR_CONVERTER_RATE ? rate_table<Opened>() : nullptr;
    };
  }
  return table;
}

}  // namespace weir

// Exports the class `Converter`: its name, other names (comma list), the caps it takes as
// GStreamer text, what its options are (JSON as in abi.h).
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
