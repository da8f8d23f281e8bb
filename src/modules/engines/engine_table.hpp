// EngineTable<Engine>: the C table of an engine that is written as two classes with Results.
#pragma once
#include <memory>
#include <span>

#include "module_host.hpp"

namespace weir::engine {

// Engine has the types Model and Session and the static functions that are called below; a Session
// may use its Model, which the host keeps until the last Session is gone.
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
    return guarded(error, [&] { return of(session).control(op, option); });
  }

  static weir_engine make(const char* name, const char* version, const char* aliases,
                          const char* extensions) {
    weir_engine table{};
    table.struct_size = sizeof table;
    table.abi_major = WEIR_ABI_MAJOR;
    table.abi_minor = WEIR_ABI_MINOR;
    table.name = name;
    table.version = version;
    table.aliases = aliases;
    table.extensions = extensions;
    table.probe = probe;
    table.open = open;
    table.close = close;
    table.info = info;
    table.session_new = session_new;
    table.session_free = session_free;
    table.resolve = resolve;
    table.invoke = invoke;
    table.control = control;
    table.extension = Engine::extension;
    return table;
  }
};

}  // namespace weir::engine
