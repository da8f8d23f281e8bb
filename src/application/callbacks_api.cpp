// ml_pipeline_custom_easy_filter_* and ml_pipeline_tensor_if_custom_*.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <map>
#include <mutex>
#include <vector>

#include "callback_holds.hpp"
#include "capi-nnstreamer/nnstreamer.h"
#include "core/infer/queue/call_gate.hpp"
#include "core/process/process_object.hpp"
#include "library/process.h"
#include "ml_error.hpp"
#include "sink_callbacks.hpp"
#include "tensors_data.hpp"
#include "weir/c_error.hpp"
#include "weir/custom_condition.h"
#include "weir/custom_filter.h"

namespace {

using namespace weir;
using namespace weir::application;

// The names in use, with the number of their holds.
struct Holds {
  std::mutex mutex;  // guards the rest
  std::map<CallbackName, size_t> counts;
};

Holds& all_holds() {
  static auto* holds = new Holds;
  return *holds;
}

// The state that Weir calls: streams may hold it after the program's handle is destroyed.
template <class Function>
struct Callback {
  std::string name;
  Function function;
  void* data;
  infer::CallGate gate;
};
using FilterCallback = Callback<ml_custom_easy_invoke_cb>;
using ConditionCallback = Callback<ml_pipeline_if_custom_cb>;

template <class Callback>
class Registered : public Object {
 public:
  static constexpr const char* kKind = "registered callback";
  explicit Registered(std::shared_ptr<Callback> callback) : callback_(std::move(callback)) {}
  const char* kind() const noexcept override { return kKind; }
  Callback& callback() const noexcept { return *callback_; }

 private:
  const std::shared_ptr<Callback> callback_;
};
using RegisteredFilter = Registered<FilterCallback>;
using RegisteredCondition = Registered<ConditionCallback>;

int refuse(const weir_host* host, weir_error* error, const std::string& what) {
  host->fail(error, WEIR_CALLBACK_FAILED, what.c_str(), nullptr, nullptr, nullptr, nullptr);
  return -WEIR_CALLBACK_FAILED;
}

// Runs `body`, which calls the program, if the callback is still registered. A result that
// `is_fault` accepts is an error.
template <class Callback, class Body>
int call(Callback& callback, const weir_host* host, weir_error* error, bool (*is_fault)(int),
         Body&& body) noexcept {
  try {
    const infer::CallGate::Visit visit(callback.gate);
    if (!visit)
      return refuse(host, error, "the callback of " + callback.name + " is no longer registered");
    const void* const outer = pipeline_of_callback();
    const InCallback here(outer ? outer : &kSomePipeline);
    const int result = body();
    if (!is_fault(result)) return result;
    return refuse(host, error,
                  "the callback of " + callback.name + " returned " + std::to_string(result));
  } catch (const std::exception& e) {
    return refuse(host, error, e.what());
  }
}

std::shared_ptr<TensorsData> lend(const weir_frame& frame, TensorsData::Access access) {
  return make_data({frame.tensors, frame.n_tensors}, nullptr, access);
}

int invoke(const weir_host* host, const weir_frame* in, weir_frame* out, void* data,
           weir_error* error) {
  auto& callback = **static_cast<std::shared_ptr<FilterCallback>*>(data);
  constexpr auto is_fault = [](int result) { return result < 0; };  // above 0: no output
  return call(callback, host, error, is_fault, [&] {
    const LentHandle inputs(lend(*in, TensorsData::Access::ReadOnly));
    const LentHandle outputs(lend(*out, TensorsData::Access::ReadWrite));
    return callback.function(inputs.get(), outputs.get(), callback.data);
  });
}

int decide(const weir_host* host, const weir_frame* in, int* result, void* data,
           weir_error* error) {
  auto& callback = *static_cast<ConditionCallback*>(data);
  constexpr auto is_fault = [](int result) { return result != 0; };
  return call(callback, host, error, is_fault, [&] {
    const auto frame = lend(*in, TensorsData::Access::ReadOnly);
    const LentHandle tensors(frame);
    const LentHandle info(std::make_shared<TensorsInfo>(frame->tensors()));
    return callback.function(tensors.get(), info.get(), result, callback.data);
  });
}

Status register_filter(const std::shared_ptr<FilterCallback>& callback, const TensorSpecs& in,
                       const TensorSpecs& out) {
  const auto inputs = c_infos(in), outputs = c_infos(out);
  auto held = std::make_unique<std::shared_ptr<FilterCallback>>(callback);
  weir_filter filter{};
  filter.struct_size = sizeof filter;
  filter.n_inputs = static_cast<uint32_t>(inputs.size());
  filter.n_outputs = static_cast<uint32_t>(outputs.size());
  filter.inputs = inputs.data();
  filter.outputs = outputs.data();
  filter.invoke = invoke;
  filter.data = held.get();
  filter.release = [](void* data) { delete static_cast<std::shared_ptr<FilterCallback>*>(data); };
  CError error;
  const int result = weir_filter_register(callback->name.c_str(), &filter, error.place());
  if (result < 0) return error.take(result);
  (void)held.release();
  return ok();
}

// Elements keep conditions and never release them: these stay until the process ends.
void keep(std::shared_ptr<ConditionCallback> callback) {
  static std::mutex mutex;
  static auto* kept = new std::vector<std::shared_ptr<ConditionCallback>>;
  std::lock_guard lock(mutex);
  kept->push_back(std::move(callback));
}

Error in_use(const std::string& name) {
  return Error{.code = Code::OPTION_VALUE,
               .what = "a pipeline uses the callback, which stays registered",
               .offered = "\"" + name + "\"",
               .needed = "a callback that no pipeline uses",
               .fix = "ml_pipeline_destroy(pipe) before this call"};
}

Error not_registered(const std::string& name) {
  return Error{.code = Code::CALLBACK_UNKNOWN,
               .what = "the callback is no longer registered under its name",
               .offered = "\"" + name + "\""};
}

// `free_name` removes the name and returns an error below 0.
template <class Registered, class Free>
int unregister(void* handle, const char* what, CallbackKind kind, Free&& free_name) {
  return guarded([&] {
    const auto found = Handles::all().find<Registered>(handle, what);
    if (!found) return fail(found.error());
    auto& callback = (*found)->callback();
    int result = 0;
    Status status = ok();
    const bool is_removed = remove_unless_held({kind, callback.name}, [&] {
      const auto taken = Handles::all().take<Registered>(handle, what);
      if (taken)
        result = free_name(callback.name.c_str());
      else
        status = taken.error();
    });
    if (!is_removed) return fail(in_use(callback.name));
    if (!status) return fail(status.error());
    callback.gate.close();
    return result < 0 ? fail(Refusal{ML_ERROR_STREAMS_PIPE, not_registered(callback.name)})
                      : static_cast<int>(ML_ERROR_NONE);
  });
}

}  // namespace

namespace weir::application {

void hold_callback(const CallbackName& name) {
  auto& holds = all_holds();
  std::lock_guard lock(holds.mutex);
  ++holds.counts[name];
}

void release_callback(const CallbackName& name) {
  auto& holds = all_holds();
  std::lock_guard lock(holds.mutex);
  if (--holds.counts[name] == 0) holds.counts.erase(name);
}

bool remove_unless_held(const CallbackName& name, const std::function<void()>& remove) {
  auto& holds = all_holds();
  std::lock_guard lock(holds.mutex);
  if (holds.counts.contains(name)) return false;
  remove();
  return true;
}

}  // namespace weir::application

// Runs when the library is loaded: a filter or condition of a program is registered for the
// process, also where the linker takes this library's copy of a register function.
__attribute__((constructor)) static void take_objects_of_the_process() {
  process::take_objects_from(weir_process_object);
}

int ml_pipeline_custom_easy_filter_register(const char* name, const ml_tensors_info_h in,
                                            const ml_tensors_info_h out,
                                            ml_custom_easy_invoke_cb cb, void* user_data,
                                            ml_custom_easy_filter_h* custom) {
  return guarded([&] {
    if (!custom) return fail(null_pointer("custom"));
    if (!name || !cb || !in || !out) return fail(null_pointer("name, cb, in or out"));
    const auto inputs = tensors_or_none(in, "in"), outputs = tensors_or_none(out, "out");
    if (!inputs) return fail(inputs.error());
    if (!outputs) return fail(outputs.error());
    const auto callback = std::make_shared<FilterCallback>();
    callback->name = name;
    callback->function = cb;
    callback->data = user_data;
    if (auto status = register_filter(callback, *inputs, *outputs); !status)
      return fail(status.error());
    *custom = Handles::all().add(std::make_shared<RegisteredFilter>(callback));
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_pipeline_custom_easy_filter_unregister(ml_custom_easy_filter_h custom) {
  return unregister<RegisteredFilter>(custom, "custom", CallbackKind::Filter,
                                      weir_filter_unregister);
}

int ml_pipeline_tensor_if_custom_register(const char* name, ml_pipeline_if_custom_cb cb,
                                          void* user_data, ml_pipeline_if_h* if_custom) {
  return guarded([&] {
    if (!if_custom) return fail(null_pointer("if_custom"));
    if (!name || !cb) return fail(null_pointer("name or cb"));
    const auto callback = std::make_shared<ConditionCallback>();
    callback->name = name;
    callback->function = cb;
    callback->data = user_data;
    if (weir_condition_register(name, decide, callback.get()) < 0)
      return fail(Error{.code = Code::OPTION_VALUE,
                        .what = "the condition cannot be registered under this name",
                        .offered = "\"" + callback->name + "\"",
                        .needed = "a non-empty name that no other condition has"});
    keep(callback);
    *if_custom = Handles::all().add(std::make_shared<RegisteredCondition>(callback));
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_pipeline_tensor_if_custom_unregister(ml_pipeline_if_h if_custom) {
  return unregister<RegisteredCondition>(if_custom, "if_custom", CallbackKind::Condition,
                                         weir_condition_unregister);
}
