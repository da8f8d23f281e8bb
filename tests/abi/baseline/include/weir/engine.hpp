// An engine in C++: write a class, export it with one line and build it as libweir-engine-NAME.so.
//
//   class Doubler {
//    public:
//     explicit Doubler(const weir::OpenRequest& request);
//     std::span<const weir_tensor_info> inputs() const;
//     std::span<const weir_tensor_info> outputs() const;
//     bool invoke(std::span<const weir_tensor> in, std::span<weir_tensor> out);
//   };
//   WEIR_ENGINE(Doubler, "doubler", "1.0", "", "dbl")
//
// The memory that inputs() and outputs() point to lives as long as the object (module.hpp:
// tensor_info). invoke returns false to drop the frame. It may take frames with their times and
// source maps instead:
//     bool invoke(const weir_frame& in, weir_frame& out);
// Each function may throw weir::Failure or any exception, which becomes an error on the bus. An
// object is one open model with its only session, used by one thread at a time; workers=N opens N
// objects. Shapes are outermost-first, -1 = unknown. Outputs of known size come with memory of that
// size. For the others `data` is null: the engine allocates memory from the host (module.hpp:
// allocate), or sets its own with release and owner.
//
// Optional members:
//     void resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
//         computes the outputs' shapes for these inputs where outputs() leaves extents open
//     void describe(weir_model_info& info) const;
//         sets flags (WEIR_MODEL_...), input alignment and padding, weight_bytes, metadata
//     void submit(const weir_frame& in, weir::Request& request);
//         for invoke-async=true: moves the request away and answers it from any thread, with any
//         number of outputs; `in` is readable until then
//     void cancel(const weir_request* request);
//         the result of the submit() whose Request has this id() is no longer needed: end() it
//         soon. Called on any thread, possibly when it has just ended. An engine without this
//         function polls Request::cancelled() instead
//     void control(int op, const weir_option* option);
//         op: weir_control
//     static constexpr const char* kOptions = "[...]";                 abi.h: options_json
//     static constexpr uint64_t kFlags = WEIR_ENGINE_NEEDS_NO_MODEL;   abi.h: weir_engine_flag
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <utility>

#include "weir/module.hpp"

namespace weir {

// The model to open and its settings. The texts are valid for the call.
struct OpenRequest {
  std::span<const char* const> paths;  // of the model's files
  Options options;
  std::string_view accelerator;
  int threads;  // 0 = the engine's own choice
};

// One frame of submit(). end() or fail() completes it; a request destroyed before that completes
// with an error. Movable; used by one thread at a time.
class Request {
 public:
  explicit Request(weir_request* handle) noexcept : handle_(handle) {}
  Request(Request&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  Request& operator=(Request&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Request() {
    if (!handle_) return;
    module_host->fail(module_host->error_of(handle_), WEIR_INVOKE_FAILED,
                      "the engine abandoned a frame without an answer", nullptr, nullptr, nullptr,
                      nullptr);
    module_host->complete(std::exchange(handle_, nullptr), -WEIR_INVOKE_FAILED, nullptr, 0);
  }

  // Returns the argument of cancel(); null once the request is completed.
  const weir_request* id() const noexcept { return handle_; }
  // Returns true when the result is no longer needed: end() soon.
  bool cancelled() const noexcept { return module_host->cancelled(handle_) != 0; }
  // Adds one output of all the model's tensors; the host takes over their memory.
  void output(std::span<weir_tensor> tensors) {
    weir_frame frame{};
    frame.struct_size = sizeof frame;
    frame.n_tensors = static_cast<uint32_t>(tensors.size());
    frame.tensors = tensors.data();
    frame.pts = frame.duration = frame.deadline = -1;
    module_host->complete(handle_, WEIR_OK, &frame, 1);
  }
  void end() noexcept {
    module_host->complete(std::exchange(handle_, nullptr), WEIR_OK, nullptr, 0);
  }
  void fail(const Error& error) {
    const int result = weir::fail(module_host->error_of(handle_), error);
    module_host->complete(std::exchange(handle_, nullptr), result, nullptr, 0);
  }
  // Detaches the request. Returns true unless it has been moved away or completed.
  bool release() noexcept { return std::exchange(handle_, nullptr) != nullptr; }

 private:
  weir_request* handle_;
};

// The C functions of an engine whose model and only session are one object.
template <class Engine>
struct EngineTable {
  static constexpr bool kSubmits = requires { &Engine::submit; };
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
      if constexpr (kSubmits) info->flags |= WEIR_MODEL_ASYNC | WEIR_MODEL_CANCELS;
      if constexpr (requires { std::as_const(of(model)).describe(*info); })
        std::as_const(of(model)).describe(*info);
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
      if constexpr (requires { of(session).invoke(*in, *out); })
        return of(session).invoke(*in, *out) ? 0 : 1;
      else
        return of(session).invoke(std::span<const weir_tensor>(in->tensors, in->n_tensors),
                                  std::span(out->tensors, out->n_tensors))
                   ? 0
                   : 1;
    });
  }
  static int submit(weir_session* session, const weir_frame* in, weir_request* request,
                    weir_error* error) {
    Request given(request);
    const int result = guarded(error, [&] {
      of(session).submit(*in, given);
      return WEIR_OK;
    });
    // A request that was moved away before the exception is completed by its new owner.
    return result < 0 && given.release() ? result : WEIR_OK;
  }
  static void cancel(weir_session* session, weir_request* request) {
    guarded(nullptr, [&] {
      of(session).cancel(request);
      return WEIR_OK;
    });
  }
  static int control(weir_session* session, int op, const weir_option* option, weir_error* error) {
    return guarded(error, [&] {
      of(session).control(op, option);
      return WEIR_OK;
    });
  }
};

// Makes the C table for the class `Engine`.
template <class Engine>
weir_engine engine_table(const char* name, const char* version, const char* aliases,
                         const char* extensions) {
  using Table = EngineTable<Engine>;
  weir_engine table{};
  table.struct_size = sizeof table;
  table.abi_major = WEIR_ABI_MAJOR;
  table.abi_minor = WEIR_ABI_MINOR;
  table.name = name;
  table.version = version;
  table.aliases = aliases;
  table.extensions = extensions;
  table.open = Table::open;
  table.close = Table::close;
  table.info = Table::info;
  table.session_new = Table::session_new;
  table.session_free = Table::session_free;
  table.resolve = Table::resolve;
  table.invoke = Table::invoke;
  if constexpr (Table::kSubmits) table.submit = Table::submit;
  if constexpr (requires(Engine & e) { e.cancel(nullptr); }) table.cancel = Table::cancel;
  if constexpr (requires(Engine & e) { e.control(0, nullptr); }) table.control = Table::control;
  if constexpr (requires { Engine::kOptions; }) table.options_json = Engine::kOptions;
  if constexpr (requires { Engine::kFlags; }) table.flags = Engine::kFlags;
  return table;
}

}  // namespace weir

// Exports the class `Engine` under `name` (for framework=) and `aliases`, with its `version` and
// the file name `extensions` of its models. The lists are comma-separated.
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
