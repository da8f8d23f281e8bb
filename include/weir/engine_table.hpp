// EngineTable<Engine>: makes the C table and module of an engine from two classes that return
// Result.
//
// Engine has
//   kName, kAliases, kExtensions of its table; kOptions: abi.h, options_json
//   kLibrary                    what errors call its library: "ONNX Runtime"
//   Model, Session              a Session may use its Model, which the host keeps alive longer
//   static int probe(const std::string& path, std::span<const unsigned char> head);
//   static Result<LibraryFacts> library();              ENGINE_NOT_INSTALLED: missing or unusable
// and may have
//   kAccelerators               comma list for "weir.accelerators/1"; "cpu" by default
//   kFlags                      abi.h: weir_engine_flag
//   static weir_engine around(const weir_engine& own);  a table that wraps the engine's own
// Model has open and describe, and may have
//   weir_execution execution() const noexcept;   how it runs, for "weir.execution/1"
//   std::vector<weir_statistic> statistics() const;  its counts, for "weir.statistics/1"
//   std::vector<weir_server> servers() const;        its servers, for "weir.servers/1"; then a
//                                                    session has: const char* answered_by() const
// Session has create, resolve and invoke, which returns what guarded() takes, and may have
//   Status warm();              WEIR_WARM; without it, nothing to warm
//   Status reset_state();       WEIR_RESET_STATE; without it, no state
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "weir/engine_tools.hpp"

namespace weir::engine {

// The library that an engine uses: its file and its version.
struct LibraryFacts {
  std::string path, version;
};

// The functions of the C table; see weir_engine in abi.h for what the host asks of each.
template <class Engine>
struct EngineTable {
  using Model = typename Engine::Model;
  using Session = typename Engine::Session;

  static Model& of(weir_model* model) { return *reinterpret_cast<Model*>(model); }
  static Session& of(weir_session* session) { return *reinterpret_cast<Session*>(session); }

  static int probe(const char* path, const void* head, size_t n, int* score, weir_error* error) {
    return guarded(error, [&]() -> Status {
      const std::span bytes(static_cast<const unsigned char*>(head), head ? n : 0);
      *score = Engine::probe(path ? path : "", bytes);
      return ok();
    });
  }
  static int open(const weir_open* request, weir_model** out, weir_error* error) {
    *out = nullptr;
    return guarded(error, [&]() -> Status {
      auto model = Model::open(*request);
      if (!model) return model.error();
      *out = reinterpret_cast<weir_model*>(model->release());
      malloc_trim(0);  // returns memory that only loading used, such as copies of the weights
      return ok();
    });
  }
  static void close(weir_model* model) {
    guarded(nullptr, [&]() -> Status {
      std::unique_ptr<Model> ended(reinterpret_cast<Model*>(model));
      return ok();
    });
  }
  static int info(weir_model* model, weir_model_info* info, weir_error* error) {
    return guarded(error, [&]() -> Status {
      of(model).describe(info);
      return ok();
    });
  }
  static int session_new(weir_model* model, const weir_option* options, uint32_t n,
                         weir_session** out, weir_error* error) {
    *out = nullptr;
    return guarded(error, [&]() -> Status {
      auto session = Session::create(of(model), std::span(options, options ? n : 0));
      if (!session) return session.error();
      *out = reinterpret_cast<weir_session*>(session->release());
      return ok();
    });
  }
  static void session_free(weir_session* session) {
    guarded(nullptr, [&]() -> Status {
      std::unique_ptr<Session> ended(reinterpret_cast<Session*>(session));
      return ok();
    });
  }
  static int resolve(weir_session* session, const weir_tensor_info* in, uint32_t n_in,
                     weir_tensor_info* out, uint32_t n_out, weir_error* error) {
    return guarded(error,
                   [&] { return of(session).resolve(std::span(in, n_in), std::span(out, n_out)); });
  }
  static int invoke(weir_session* session, const weir_frame* in, weir_frame* out,
                    weir_error* error) {
    return guarded(error, [&] { return of(session).invoke(*in, *out); });
  }
  static int control(weir_session* session, int op, const weir_option* option, weir_error* error) {
    return guarded(error, [&]() -> Status {
      switch (op) {
        case WEIR_WARM:
          if constexpr (requires(Session & s) { s.warm(); }) return of(session).warm();
          return ok();
        case WEIR_RESET_STATE:
          if constexpr (requires(Session & s) { s.reset_state(); })
            return of(session).reset_state();
          return ok();
        case WEIR_SUSPEND:  // only the model could free memory, and the host closes it for that
          return Error{
              .code = Code::MODEL_UNSUPPORTED,
              .what = std::string(Engine::kLibrary) + " cannot free the memory of an open model",
              .offered = "suspend"};
        case WEIR_SET_OPTION:
          return Error{.code = Code::OPTION_VALUE,
                       .what = std::string(Engine::kLibrary) +
                               " accepts options only when a model is opened",
                       .offered = option && option->key ? option->key : "",
                       .needed = "custom= at the start"};
        default:
          return ok();
      }
    });
  }
  static int execution(weir_model* model, weir_execution* out) {
    const weir_execution found = of(model).execution();
    const auto fits = [out](size_t end) { return out->struct_size >= end; };
    if (fits(offsetof(weir_execution, spins))) out->threads = found.threads;
    if (fits(offsetof(weir_execution, spins) + sizeof found.spins)) out->spins = found.spins;
    return WEIR_OK;
  }
  static int read_statistics(weir_model* model, weir_statistic* out, uint32_t room) {
    return guarded(nullptr, [&] {
      const auto all = of(model).statistics();
      std::copy_n(all.begin(), std::min<size_t>(all.size(), room), out);
      return static_cast<int>(all.size());
    });
  }
  static int read_servers(weir_model* model, weir_server* out, uint32_t room) {
    return guarded(nullptr, [&] {
      const auto all = of(model).servers();
      std::copy_n(all.begin(), std::min<size_t>(all.size(), room), out);
      return static_cast<int>(all.size());
    });
  }
  static const char* answered_by(weir_session* session) { return of(session).answered_by(); }
  static const void* extension(const char* id) {
    if (!id) return nullptr;
    if (std::string_view(id) == "weir.library-problem/1") return library_problem();
    if constexpr (requires(const Model& model) { model.execution(); })
      if (std::string_view(id) == WEIR_EXECUTION) {
        static constexpr weir_execution_calls calls{sizeof calls, execution};
        return &calls;
      }
    if constexpr (requires(const Model& model) { model.statistics(); })
      if (std::string_view(id) == WEIR_ENGINE_STATISTICS) {
        static constexpr weir_engine_statistics calls{sizeof calls, read_statistics};
        return &calls;
      }
    if constexpr (requires(const Model& model) { model.servers(); })
      if (std::string_view(id) == WEIR_ENGINE_SERVERS) {
        static constexpr weir_engine_servers calls{sizeof calls, read_servers, answered_by};
        return &calls;
      }
    if (std::string_view(id) == "weir.accelerators/1") {
      if constexpr (requires { Engine::kAccelerators; }) return Engine::kAccelerators;
      return "cpu";
    }
    if (std::string_view(id) != "weir.library/1") return nullptr;
    const Result<LibraryFacts> found = Engine::library();
    if (!found) return nullptr;
    static const LibraryFacts facts = *found;
    static const std::array library{facts.path.c_str(), facts.version.c_str()};
    return library.data();
  }
  static const void* library_problem() {
    const Result<LibraryFacts> found = Engine::library();
    if (found) return nullptr;
    thread_local Error problem;
    thread_local std::array<const char*, 2> texts;
    problem = found.error();
    if (!problem.offered.empty()) problem.what += ": " + problem.offered;
    texts = {problem.what.c_str(), problem.fix.c_str()};
    return texts.data();
  }

  // Makes the table, for the whole life of the process.
  static weir_engine make() {
    weir_engine table{};
    table.struct_size = sizeof table;
    table.abi_major = WEIR_ABI_MAJOR;
    table.abi_minor = WEIR_ABI_MINOR;
    table.name = Engine::kName;
    table.version = "1";
    table.aliases = Engine::kAliases;
    table.extensions = Engine::kExtensions;
    table.options_json = Engine::kOptions;
    table.probe = probe;
    table.open = open;
    table.close = close;
    table.info = info;
    table.session_new = session_new;
    table.session_free = session_free;
    table.resolve = resolve;
    table.invoke = invoke;
    table.control = control;
    table.extension = extension;
    if constexpr (requires { Engine::kFlags; }) table.flags = Engine::kFlags;
    return table;
  }
};

// Returns the module with this one engine, for the host that loaded it.
template <class Engine>
const weir_module* get_module(const weir_host* host) {
  if (!accept_host(host)) return nullptr;
  module_name = Engine::kName;
  static const weir_engine own = EngineTable<Engine>::make();
  static const weir_engine engine = [] {
    if constexpr (requires { Engine::around(own); }) return Engine::around(own);
    return own;
  }();
  static const weir_engine* const engines[] = {&engine, nullptr};
  static const weir_module module{sizeof(weir_module),
                                  WEIR_ABI_MAJOR,
                                  WEIR_ABI_MINOR,
                                  engines,
                                  nullptr,
                                  nullptr,
                                  nullptr,
                                  nullptr};
  return &module;
}

}  // namespace weir::engine

// Exports the module's entry point. Use it at the end of the engine's file, outside all namespaces.
#define WEIR_ENGINE_MODULE(Engine)                                                        \
  extern "C" __attribute__((visibility("default"))) const weir_module* weir_module_entry( \
      const weir_host* host) {                                                            \
    return weir::engine::get_module<Engine>(host);                                        \
  }
