// A decoder in C++: write a class, export it with one line, build it as libweir-decoder-NAME.so.
//
//   class Brightness {
//    public:
//     explicit Brightness(const weir::Options& options);
//     void configure(std::span<const weir_tensor_info> inputs, weir::DecoderOutput& output);
//     bool decode(const weir_frame& frame, weir::DecoderOutput& output);
//     void reset() noexcept;
//   };
//   WEIR_DECODER(Brightness, "brightness", "", "[]")
//
// configure comes before the first frame and when the stream's format changes. `inputs` is empty
// when the stream is flexible: each frame says its own shapes then. decode returns false to drop a
// frame. reset may be left out: it forgets what was kept of earlier frames, for a flush or a seek
// came. Each other function may throw weir::Failure, or anything: it becomes an error on the bus.
// One object is used by one thread at a time. Shapes in weir_tensor_info are outermost-first
// (abi.h, rule C).
#pragma once
#include <memory>
#include <utility>

#include "weir/module.hpp"

namespace weir {

// Where a decoder puts its caps (in configure) and its bytes (in decode).
class DecoderOutput {
 public:
  explicit DecoderOutput(weir_sink* sink)
      : sink_(sink),
        calls_(static_cast<const weir_sink_calls*>(module_host->extension("weir.sink/1"))) {
    if (!calls_) throw Failure({Code::INTERNAL, "the host has no weir.sink/1", "", "", "", ""});
  }

  // In configure, once: the output stream's caps as GStreamer text, without a framerate, which the
  // host adds.
  void set_caps(const std::string& caps) {
    // Not through weir_error: that is the caller's. A refusal is a fault of the decoder's text.
    if (calls_->set_caps(sink_, caps.c_str(), nullptr) < 0)
      throw Failure({Code::INTERNAL, "the host refuses the decoder's caps", caps, "", "", ""});
  }
  // In decode: appends `bytes` of writable memory to the output, valid until decode returns.
  std::span<std::byte> reserve(size_t bytes) {
    void* data = calls_->reserve(sink_, bytes);
    if (!data && bytes > 0) throw std::bad_alloc();
    return {static_cast<std::byte*>(data), bytes};
  }
  // In decode: appends tensor `index` of the frame, shared and not copied.
  void share_input(uint32_t index) {
    if (calls_->share_input(sink_, index, nullptr) < 0)
      throw Failure(
          {Code::INTERNAL, "the host cannot share an input", std::to_string(index), "", "", ""});
  }

 private:
  weir_sink* sink_;
  const weir_sink_calls* calls_;
};

// The C table over the class `Decoder`.
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
      return reinterpret_cast<Decoder*>(decoder)->decode(*frame, output) ? 0 : 1;
    });
  };
  if constexpr (requires(Decoder & decoder) { decoder.reset(); }) {
    static_assert(noexcept(std::declval<Decoder&>().reset()), "reset has no way to fail");
    table.reset = [](weir_decoder* decoder) { reinterpret_cast<Decoder*>(decoder)->reset(); };
  }
  return table;
}

}  // namespace weir

// Exports the class `Decoder`: its name in mode=, other names (comma list), what its options are
// (JSON as in abi.h).
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
