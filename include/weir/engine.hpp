// An engine in C++: write a class, export it with one line, build it as libweir-engine-NAME.so.
//
//   class Doubler {
//    public:
//     explicit Doubler(const weir::OpenRequest& request);
//     std::span<const weir_tensor_info> inputs() const;
//     std::span<const weir_tensor_info> outputs() const;
//     void resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
//     bool invoke(std::span<const weir_tensor> in, std::span<weir_tensor> out);
//   };
//   WEIR_ENGINE(Doubler, "doubler", "1.0", "", "dbl")
//
// What inputs and outputs point to lives as long as the object. resolve may be left out when every
// output's shape is known; it fills in what the shapes of the inputs decide. invoke returns false
// to drop the frame. Each function may throw weir::Failure, or anything: it becomes an error on the
// bus. An object is one opened model; it is used by one thread at a time. Shapes are
// outermost-first, -1 = unknown. Outputs whose size is known come with memory of that size to write
// into; for others `data` is null and the engine fills data, bytes, info, release and owner
// (module_host->allocate gives such memory).
#pragma once
#include <memory>

#include "weir/module.hpp"

namespace weir {

// What a user asks for. The texts live for the call.
struct OpenRequest {
  std::span<const char* const> paths;  // of the model's files
  Options options;
  std::string_view accelerator;
  int threads;  // 0 = the engine's own choice
};

// A model with its only session: they are one object.
template <class Engine>
struct EngineFace {
  static Engine& of(void* handle) { return *static_cast<Engine*>(handle); }
  static int open(const weir_open* request, weir_model** out, weir_error* error) {
    *out = nullptr;
    return guarded(error, [&] {
      const OpenRequest given{{request->paths, request->paths ? request->n_models : 0},
                              Options(request->options, request->n_options),
                              request->accelerator ? request->accelerator : "",
                              request->threads};
      *out = reinterpret_cast<weir_model*>(std::make_unique<Engine>(given).release());
      return WEIR_OK;
    });
  }
  static void close(weir_model* model) { delete reinterpret_cast<Engine*>(model); }
  static int info(weir_model* model, weir_model_info* info, weir_error* error) {
    return guarded(error, [&] {
      const auto inputs = of(model).inputs(), outputs = of(model).outputs();
      info->n_inputs = static_cast<uint32_t>(inputs.size());
      info->n_outputs = static_cast<uint32_t>(outputs.size());
      info->inputs = inputs.data();
      info->outputs = outputs.data();
      info->memory_kinds = uint64_t{1} << WEIR_MEMORY_HOST;
      info->max_sessions = info->max_in_flight = info->preferred_batch = 1;
      return WEIR_OK;
    });
  }
  static int session_new(weir_model* model, const weir_option*, uint32_t, weir_session** out,
                         weir_error*) {
    *out = reinterpret_cast<weir_session*>(model);
    return WEIR_OK;
  }
  static void session_free(weir_session*) {}
  static int resolve(weir_session* session, const weir_tensor_info* in, uint32_t n_in,
                     weir_tensor_info* out, uint32_t n_out, weir_error* error) {
    return guarded(error, [&] {
      if constexpr (requires { of(session).resolve(std::span(in, n_in), std::span(out, n_out)); })
        of(session).resolve(std::span(in, n_in), std::span(out, n_out));
      return WEIR_OK;
    });
  }
  static int invoke(weir_session* session, const weir_frame* in, weir_frame* out,
                    weir_error* error) {
    return guarded(error, [&] {
      const std::span<const weir_tensor> inputs(in->tensors, in->n_tensors);
      const std::span<weir_tensor> outputs(out->tensors, out->n_tensors);
      return of(session).invoke(inputs, outputs) ? 0 : 1;
    });
  }
};

// The C table over the class `Engine`.
template <class Engine>
weir_engine engine_table(const char* name, const char* version, const char* aliases,
                         const char* extensions) {
  using Face = EngineFace<Engine>;
  weir_engine table{};
  table.struct_size = sizeof table;
  table.abi_major = WEIR_ABI_MAJOR;
  table.abi_minor = WEIR_ABI_MINOR;
  table.name = name;
  table.version = version;
  table.aliases = aliases;
  table.extensions = extensions;
  table.open = Face::open;
  table.close = Face::close;
  table.info = Face::info;
  table.session_new = Face::session_new;
  table.session_free = Face::session_free;
  table.resolve = Face::resolve;
  table.invoke = Face::invoke;
  return table;
}

}  // namespace weir

// Exports the class `Engine`: its name in framework=, its version, other names and the endings of
// its model files (comma lists).
#define WEIR_ENGINE(Engine, name, version, aliases, extensions)                           \
  extern "C" __attribute__((visibility("default"))) const weir_module* weir_module_entry( \
      const weir_host* host) {                                                            \
    if (!::weir::accept_host(host)) return nullptr;                                       \
    static const weir_engine table =                                                      \
        ::weir::engine_table<Engine>(name, version, aliases, extensions);                 \
    static const weir_engine* const tables[] = {&table, nullptr};                         \
    static const weir_module module{sizeof(weir_module),                                  \
                                    WEIR_ABI_MAJOR,                                       \
                                    WEIR_ABI_MINOR,                                       \
                                    tables,                                               \
                                    nullptr,                                              \
                                    nullptr,                                              \
                                    nullptr,                                              \
                                    nullptr};                                             \
    return &module;                                                                       \
  }
