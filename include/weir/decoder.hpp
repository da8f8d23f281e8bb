// A decoder in C++: write a class, export it with one line and build it as libweir-decoder-NAME.so.
//
//   class Brightness {
//    public:
//     explicit Brightness(const weir::Options& options);
//     void configure(std::span<const weir_tensor_info> inputs, weir::DecoderOutput& output);
//     bool decode(const weir_frame& frame, weir::DecoderOutput& output);
//     void reset() noexcept;
//     void set_stream(const weir::DecoderStream& stream) noexcept;
//     void set_model(const weir_stream_model* model) noexcept;
//     void set_caps(const weir::Options& fields) noexcept;
//     void set_times(const weir::DecoderTimes& times) noexcept;
//     std::span<const char* const> labels() noexcept;
//     void set_labels(const char* source, std::span<const char* const> names) noexcept;
//     size_t classes() noexcept;
//     std::optional<weir::Error> next_warning();
//     static constexpr bool kWithHeaders = false;
//   };
//   WEIR_DECODER(Brightness, "brightness", "", "[]")
//
// The host calls configure before the first frame and when the stream's format changes. `inputs` is
// empty for flexible streams, whose frames carry their own shapes. decode returns false to drop a
// frame. The optional reset runs after a flush or a seek and discards what was kept of earlier
// frames. The optional set_stream, set_model and set_caps run before each configure, the optional
// set_times before each decode. The optional labels and set_labels pass the names of classes with
// the stream, and the optional classes their number. The optional next_warning runs after each
// decode that succeeded and returns what the host posts as a warning. With the optional
// kWithHeaders, tensors of flexible streams begin with their 128-byte headers. abi.h describes
// these extensions of a decoder. The other functions may throw weir::Failure or any exception,
// which becomes an error on the bus. An object is used by one thread at a time. Shapes in
// weir_tensor_info are outermost-first (abi.h, rule C).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <optional>
#include <utility>

#include "weir/module.hpp"

namespace weir {

// Receives the caps of a decoder (in configure) and its bytes (in decode).
class DecoderOutput {
 public:
  explicit DecoderOutput(weir_sink* sink)
      : sink_(sink),
        calls_(static_cast<const weir_sink_calls*>(module_host->extension("weir.sink/1"))) {
    if (!calls_) throw Failure({.code = Code::INTERNAL, .what = "the host has no weir.sink/1"});
  }

  // Sets the output caps as GStreamer text, without framerate, which the host adds. Called in
  // configure, once. Throws Failure (INTERNAL) when the host rejects the text.
  void set_caps(const std::string& caps) {
    // No weir_error: it belongs to the caller. Rejected caps are a bug of the decoder.
    if (calls_->set_caps(sink_, caps.c_str(), nullptr) < 0)
      throw Failure(
          {.code = Code::INTERNAL, .what = "the host rejects the decoder's caps", .offered = caps});
  }
  // Appends `bytes` of writable memory to the output. Called in decode; valid until it returns.
  // Throws std::bad_alloc.
  std::span<std::byte> reserve(size_t bytes) {
    void* data = calls_->reserve(sink_, bytes);
    if (!data && bytes > 0) throw std::bad_alloc();
    return {static_cast<std::byte*>(data), bytes};
  }
  // Appends tensor `index` of the frame without copying it. Called in decode. Throws Failure
  // (INTERNAL) for an invalid index.
  void share_input(uint32_t index) {
    if (calls_->share_input(sink_, index, nullptr) < 0)
      throw Failure({.code = Code::INTERNAL,
                     .what = "the host cannot share an input",
                     .offered = std::to_string(index)});
  }

 private:
  weir_sink* sink_;
  const weir_sink_calls* calls_;
};

// The input stream of a decoder.
struct DecoderStream {
  int32_t rate_n = 0, rate_d = 1;  // frames per second; 0/1 = variable or unknown
  bool is_flexible = false;        // each tensor carries its own description
};

// The times of a frame in nanoseconds, -1 = unknown.
struct DecoderTimes {
  int64_t running_time = -1;
  int64_t unix_time = -1;  // when it was captured, since 1970 UTC
};

// Returns the table of the extension weir.decoder-stream/1 for the class `Decoder`.
template <class Decoder>
const weir_decoder_stream* stream_table() {
  constexpr bool with_headers = [] {
    if constexpr (requires { Decoder::kWithHeaders; }) return Decoder::kWithHeaders;
    return false;
  }();
  static const weir_decoder_stream table{
      sizeof(weir_decoder_stream), with_headers ? uint32_t{WEIR_DECODER_WITH_HEADERS} : 0,
      [](weir_decoder* decoder, int32_t rate_n, int32_t rate_d, int is_flexible) {
        reinterpret_cast<Decoder*>(decoder)->set_stream({rate_n, rate_d, is_flexible != 0});
      }};
  return &table;
}

// Returns the table of the extension weir.decoder-model/1 for the class `Decoder`.
template <class Decoder>
const weir_decoder_model* model_table() {
  static const weir_decoder_model table{sizeof(weir_decoder_model), 0,
                                        [](weir_decoder* decoder, const weir_stream_model* model) {
                                          reinterpret_cast<Decoder*>(decoder)->set_model(model);
                                        }};
  return &table;
}

// Returns the table of the extension weir.decoder-caps/1 for the class `Decoder`.
template <class Decoder>
const weir_decoder_caps* caps_table() {
  static const weir_decoder_caps table{
      sizeof(weir_decoder_caps), 0,
      [](weir_decoder* decoder, const weir_option* fields, uint32_t count) {
        reinterpret_cast<Decoder*>(decoder)->set_caps(Options(fields, count));
      }};
  return &table;
}

// Returns the table of the extension weir.decoder-times/1 for the class `Decoder`.
template <class Decoder>
const weir_decoder_times* times_table() {
  static const weir_decoder_times table{
      sizeof(weir_decoder_times), 0,
      [](weir_decoder* decoder, int64_t running_time, int64_t unix_time) {
        reinterpret_cast<Decoder*>(decoder)->set_times({running_time, unix_time});
      }};
  return &table;
}

// Returns the table of the extension weir.decoder-labels/1 for the class `Decoder`.
template <class Decoder>
const weir_decoder_labels* labels_table() {
  static const weir_decoder_labels table = [] {
    weir_decoder_labels out{sizeof(weir_decoder_labels), 0, nullptr, nullptr, nullptr};
    if constexpr (requires(Decoder & decoder) { decoder.labels(); }) {
      static_assert(noexcept(std::declval<Decoder&>().labels()), "labels has no way to fail");
      out.labels = [](weir_decoder* decoder, const char* const** names) {
        const std::span<const char* const> labels = reinterpret_cast<Decoder*>(decoder)->labels();
        *names = labels.data();
        return static_cast<uint32_t>(labels.size());
      };
    }
    if constexpr (requires(Decoder & decoder) { decoder.set_labels("", {}); }) {
      static_assert(noexcept(std::declval<Decoder&>().set_labels("", {})),
                    "set_labels has no way to fail");
      out.set_labels = [](weir_decoder* decoder, const char* source, const char* const* names,
                          uint32_t count) {
        reinterpret_cast<Decoder*>(decoder)->set_labels(source, std::span(names, count));
      };
    }
    if constexpr (requires(Decoder & decoder) { decoder.classes(); }) {
      static_assert(noexcept(std::declval<Decoder&>().classes()), "classes has no way to fail");
      out.classes = [](weir_decoder* decoder) {
        return static_cast<uint32_t>(reinterpret_cast<Decoder*>(decoder)->classes());
      };
    }
    return out;
  }();
  return table.labels || table.set_labels ? &table : nullptr;
}

// Makes the C table for the class `Decoder`.
template <class Decoder>
weir_decoder_type decoder_table(const char* name, const char* aliases, const char* options_json) {
  weir_decoder_type table{};
  table.struct_size = sizeof table;
  table.abi_major = WEIR_ABI_MAJOR;
  table.abi_minor = WEIR_ABI_MINOR;
  table.name = name;
  table.aliases = aliases;
  table.options_json = options_json;
  table.open = [](const weir_option* options, uint32_t count, void*, weir_decoder** out,
                  weir_error* error) {
    *out = nullptr;
    return guarded(error, [&] {
      auto decoder = std::make_unique<Decoder>(Options(options, count));
      *out = reinterpret_cast<weir_decoder*>(decoder.release());
      return WEIR_OK;
    });
  };
  table.close = [](weir_decoder* decoder) { delete reinterpret_cast<Decoder*>(decoder); };
  table.configure = [](weir_decoder* decoder, const weir_tensor_info* inputs, uint32_t count,
                       const char*, weir_sink* sink, weir_error* error) {
    return guarded(error, [&] {
      DecoderOutput output(sink);
      reinterpret_cast<Decoder*>(decoder)->configure(std::span(inputs, count), output);
      return WEIR_OK;
    });
  };
  table.decode = [](weir_decoder* decoder, const weir_frame* frame, weir_sink* sink,
                    weir_error* error) {
    return guarded(error, [&] {
      DecoderOutput output(sink);
      auto* const self = reinterpret_cast<Decoder*>(decoder);
      const bool is_kept = self->decode(*frame, output);
      if constexpr (requires { self->next_warning(); })
        if (const std::optional<Error> warning = self->next_warning()) fail(error, *warning);
      return is_kept ? 0 : 1;
    });
  };
  if constexpr (requires(Decoder & decoder) { decoder.reset(); }) {
    static_assert(noexcept(std::declval<Decoder&>().reset()), "reset must not fail");
    table.reset = [](weir_decoder* decoder) { reinterpret_cast<Decoder*>(decoder)->reset(); };
  }
  table.extension = [](const char* id) -> const void* {
    if constexpr (requires(Decoder & decoder) { decoder.set_stream(DecoderStream{}); }) {
      static_assert(noexcept(std::declval<Decoder&>().set_stream(DecoderStream{})),
                    "set_stream has no way to fail");
      if (std::string_view(id) == WEIR_DECODER_STREAM) return stream_table<Decoder>();
    }
    if constexpr (requires(Decoder & decoder) { decoder.set_model(nullptr); }) {
      static_assert(noexcept(std::declval<Decoder&>().set_model(nullptr)),
                    "set_model has no way to fail");
      if (std::string_view(id) == WEIR_DECODER_MODEL) return model_table<Decoder>();
    }
    if constexpr (requires(Decoder & decoder, const Options& o) { decoder.set_caps(o); }) {
      static_assert(noexcept(std::declval<Decoder&>().set_caps(std::declval<const Options&>())),
                    "set_caps has no way to fail");
      if (std::string_view(id) == WEIR_DECODER_CAPS) return caps_table<Decoder>();
    }
    if constexpr (requires(Decoder & decoder) { decoder.set_times(DecoderTimes{}); }) {
      static_assert(noexcept(std::declval<Decoder&>().set_times(DecoderTimes{})),
                    "set_times has no way to fail");
      if (std::string_view(id) == WEIR_DECODER_TIMES) return times_table<Decoder>();
    }
    if (std::string_view(id) == WEIR_DECODER_LABELS) return labels_table<Decoder>();
    return nullptr;
  };
  return table;
}

}  // namespace weir

// Exports the class `Decoder` under `name` (for mode=) and `aliases` (comma-separated), with
// `options_json` (abi.h).
#define WEIR_DECODER(Decoder, name, aliases, options_json)                                \
  extern "C" __attribute__((visibility("default"))) const weir_module* weir_module_entry( \
      const weir_host* host) {                                                            \
    if (!::weir::accept_host(host)) return nullptr;                                       \
    static const weir_decoder_type table =                                                \
        ::weir::decoder_table<Decoder>(name, aliases, options_json);                      \
    static const weir_decoder_type* const tables[] = {&table, nullptr};                   \
    static const weir_module module{sizeof(weir_module),                                  \
                                    WEIR_ABI_MAJOR,                                       \
                                    WEIR_ABI_MINOR,                                       \
                                    nullptr,                                              \
                                    tables,                                               \
                                    nullptr,                                              \
                                    nullptr,                                              \
                                    nullptr};                                             \
    return &module;                                                                       \
  }
