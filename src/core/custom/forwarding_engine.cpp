// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/custom/forwarding_engine.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "core/infer/model/declared_options.hpp"
#include "core/infer/model/option_check.hpp"
#include "core/infer/module/host.hpp"
#include "weir/module.hpp"

namespace weir::custom {
namespace {

struct ForwardedModel {
  FoundEngine found;
  weir_model* model = nullptr;
  ForwardedModel() = default;
  ForwardedModel(const ForwardedModel&) = delete;
  ForwardedModel& operator=(const ForwardedModel&) = delete;
  ~ForwardedModel() {
    if (model) found.engine->close(model);
  }
};
struct ForwardedSession {
  const weir_engine* engine;
  weir_session* session;
};
ForwardedModel& of(weir_model* handle) {
  return *reinterpret_cast<ForwardedModel*>(handle);
}
ForwardedSession& of(weir_session* handle) {
  return *reinterpret_cast<ForwardedSession*>(handle);
}

Error lacks(const weir_engine& engine, const char* what) {
  return Error{.code = Code::MODEL_UNSUPPORTED,
               .what = "the engine does not support this call",
               .offered = engine.name,
               .needed = std::string("an engine with ") + what};
}

int session_new(weir_model* model, const weir_option* options, uint32_t n, weir_session** out,
                weir_error* error) {
  return guarded(error, [&] {
    const weir_engine& engine = *of(model).found.engine;
    weir_session* inner = nullptr;
    const int result = engine.session_new(of(model).model, options, n, &inner, error);
    if (result < 0) return result;
    if (!inner)
      throw Failure({.code = Code::INTERNAL,
                     .what = "the engine created no session",
                     .offered = engine.name});
    try {
      *out = reinterpret_cast<weir_session*>(
          std::make_unique<ForwardedSession>(ForwardedSession{&engine, inner}).release());
    } catch (...) {
      engine.session_free(inner);
      throw;
    }
    return 0;
  });
}

void session_free(weir_session* handle) {
  const std::unique_ptr<ForwardedSession> session(&of(handle));
  session->engine->session_free(session->session);
}

int resolve(weir_session* session, const weir_tensor_info* in, uint32_t n_in, weir_tensor_info* out,
            uint32_t n_out, weir_error* error) {
  const auto& [engine, inner] = of(session);
  return engine->resolve ? engine->resolve(inner, in, n_in, out, n_out, error) : WEIR_OK;
}

int submit(weir_session* session, const weir_frame* in, weir_request* request, weir_error* error) {
  const auto& [engine, inner] = of(session);
  return engine->submit ? engine->submit(inner, in, request, error)
                        : fail(error, lacks(*engine, "submit()"));
}

int control(weir_session* session, int op, const weir_option* option, weir_error* error) {
  const auto& [engine, inner] = of(session);
  return engine->control ? engine->control(inner, op, option, error)
                         : fail(error, lacks(*engine, "control()"));
}

// Those before the name by which the engine was requested (core/infer/model/declared_options.hpp).
std::vector<std::pair<std::string, std::string>> users_options(const weir_open& request) {
  std::vector<std::pair<std::string, std::string>> out;
  for (uint32_t i = 0; i < request.n_options; ++i)
    out.emplace_back(request.options[i].key, request.options[i].value);
  const auto own = std::find_if(out.rbegin(), out.rend(),
                                [](const auto& option) { return option.first == "framework"; });
  if (own != out.rend()) out.erase(own.base() - 1, out.end());
  return out;
}

}  // namespace

int forward_open(FindEngine find, const weir_open* request, weir_model** out, weir_error* error) {
  *out = nullptr;
  return guarded(error, [&] {
    auto model = std::make_unique<ForwardedModel>();
    model->found = value_or_throw(find(*request));
    const weir_engine& engine = *model->found.engine;
    weir_open inner = *request;
    inner.paths += model->found.paths_used;
    inner.n_models -= model->found.paths_used;
    if (const auto status = infer::check_options(engine, users_options(*request)); !status)
      return fail(error, status.error());
    const auto options = infer::options_for_inner(engine, *request);
    inner.options = options.data();
    inner.n_options = static_cast<uint32_t>(options.size());
    const int result = engine.open(&inner, &model->model, error);
    if (result < 0) return result;
    if (!model->model)
      throw Failure({.code = Code::MODEL_INVALID,
                     .what = "the engine opened no model",
                     .offered = engine.name});
    *out = reinterpret_cast<weir_model*>(model.release());
    return 0;
  });
}

weir_engine forwarding_functions() {
  accept_host(&infer::host());
  weir_engine table{};
  table.struct_size = sizeof table;
  table.abi_major = WEIR_ABI_MAJOR;
  table.abi_minor = WEIR_ABI_MINOR;
  table.version = "1";
  table.options_json = infer::kAllDeclared;
  table.aliases = table.extensions = "";
  table.close = [](weir_model* model) { delete &of(model); };
  table.info = [](weir_model* model, weir_model_info* info, weir_error* error) {
    return of(model).found.engine->info(of(model).model, info, error);
  };
  table.session_new = session_new;
  table.session_free = session_free;
  table.resolve = resolve;
  table.invoke = [](weir_session* session, const weir_frame* in, weir_frame* out,
                    weir_error* error) {
    return of(session).engine->invoke(of(session).session, in, out, error);
  };
  table.submit = submit;
  table.cancel = [](weir_session* session, weir_request* request) {
    if (of(session).engine->cancel) of(session).engine->cancel(of(session).session, request);
  };
  table.control = control;
  return table;
}

}  // namespace weir::custom
