// tensor_filter_cpp objects as engines of framework=cpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cerrno>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>

#include "compat/filter_model.hpp"
#include "compat/registration.hpp"
#include "core/infer/module/host.hpp"
#include "tensor_filter_cpp.hh"
#include "weir/custom_filter.h"

using namespace weir::compat;

namespace {

// An object serves all elements that name it, one call at a time.
struct Object {
  tensor_filter_cpp* filter;
  std::mutex turn;
};
struct Objects {
  std::mutex mutex;  // guards the rest
  std::map<std::string, std::shared_ptr<Object>, std::less<>> all;
  std::deque<std::string> names;  // engine names, which outlive the objects
};
Objects& objects() {
  static auto& all = *new Objects;  // never freed: elements may outlive static objects
  return all;
}

class OpenObject final : public OpenFilter {
 private:
  template <class Body>
  auto ask(const char* function, Body&& body) {
    const std::lock_guard lock(object_->turn);
    return call(function, [&] { return body(*object_->filter); });
  }

 public:
  OpenObject(std::shared_ptr<Object> object, std::unique_ptr<Properties> properties)
      : OpenFilter(std::move(properties)), object_(std::move(object)) {
    this->properties().choose_hardware({}, ACCL_AUTO, ACCL_DEFAULT, false);
  }
  Known get_info(GstTensorsInfo* in, GstTensorsInfo* out) override {
    const int inputs = ask("getInputDim", [&](auto& f) { return f.getInputDim(in); });
    const int outputs = ask("getOutputDim", [&](auto& f) { return f.getOutputDim(out); });
    return {inputs >= 0, outputs >= 0};
  }
  int set_inputs(const GstTensorsInfo* in, GstTensorsInfo* out) override {
    return ask("setInputDim", [&](auto& f) { return f.setInputDim(in, out); });
  }
  int invoke(const GstTensorMemory* in, GstTensorMemory* out) override {
    return ask("invoke", [&](auto& f) { return f.invoke(in, out); });
  }
  bool allocates() override {
    return ask("isAllocatedBeforeInvoke", [](auto& f) { return !f.isAllocatedBeforeInvoke(); });
  }
  void destroy(void* data) override { g_free(data); }

 private:
  std::shared_ptr<Object> object_;
};

std::shared_ptr<OpenFilter> open_object(const weir::OpenRequest& request) {
  const std::string name(request.options.get("framework").value_or(""));
  std::unique_lock lock(objects().mutex);
  const auto found = objects().all.find(name);
  if (found == objects().all.end())
    throw weir::Failure({.code = weir::Code::CALLBACK_UNKNOWN,
                         .what = "the filter object is no longer registered",
                         .offered = "framework=cpp model=" + name,
                         .needed = "an object that stays registered while a pipeline uses it"});
  const auto object = found->second;
  lock.unlock();
  return std::make_shared<OpenObject>(object, std::make_unique<Properties>("cpp", name, request));
}

thread_local const char* name_of_entry = nullptr;

// The caller copies it immediately.
const weir_module* entry(const weir_host* host) {
  weir::accept_host(host);
  thread_local weir_engine table;
  thread_local const weir_engine* const tables[] = {&table, nullptr};
  thread_local const weir_module module{sizeof(weir_module),
                                        WEIR_ABI_MAJOR,
                                        WEIR_ABI_MINOR,
                                        tables,
                                        nullptr,
                                        nullptr,
                                        nullptr,
                                        nullptr};
  table = weir::engine_table<Opened<open_object>>(name_of_entry, "1", "", "");
  table.flags = WEIR_ENGINE_NEEDS_NO_MODEL | WEIR_ENGINE_MODEL_IS_NO_FILE;
  return &module;
}

constexpr char kRegister[] = "tensor_filter_cpp::__register";

int add(tensor_filter_cpp* filter) {
  const std::string name = filter->getName();
  {
    std::lock_guard lock(objects().mutex);
    if (objects().all.contains(name)) {
      warn(kRegister, "another object already has the name " + name);
      return -EINVAL;
    }
    name_of_entry = objects().names.emplace_back(name).c_str();
    auto object = std::make_shared<Object>();
    object->filter = filter;
    objects().all.emplace(name, std::move(object));
  }
  weir_error* error = nullptr;
  const int code = weir_filter_class_register(name.c_str(), entry, &error);
  if (code == WEIR_OK) return 0;
  std::lock_guard lock(objects().mutex);
  objects().all.erase(name);
  return to_errno(kRegister, code, error);
}

}  // namespace

tensor_filter_cpp::tensor_filter_cpp(const char* modelName)
    : name_(g_strdup(modelName ? modelName : "")) {}

tensor_filter_cpp::~tensor_filter_cpp() {
  bool ours = false;
  {
    std::lock_guard lock(objects().mutex);
    const auto found = objects().all.find(name_);
    ours = found != objects().all.end() && found->second->filter == this;
  }
  if (ours) __unregister(name_);
  g_free(name_);
}

int tensor_filter_cpp::__register(tensor_filter_cpp* filter) {
  if (!given(kRegister, {filter})) return -EINVAL;
  return guarded_errno(kRegister, [&] { return add(filter); });
}

int tensor_filter_cpp::__unregister(const char* modelName) {
  if (!given("tensor_filter_cpp::__unregister", {modelName})) return -EINVAL;
  return guarded_errno("tensor_filter_cpp::__unregister", [&] {
    std::lock_guard lock(objects().mutex);
    const auto found = objects().all.find(modelName);
    if (found == objects().all.end()) return -EINVAL;
    objects().all.erase(found);
    return to_errno("tensor_filter_cpp::__unregister", weir_filter_class_unregister(modelName));
  });
}
