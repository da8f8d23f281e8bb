// tensor_filter_cpp objects as engines of framework=cpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cerrno>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <vector>

#include "compat/filter_model.hpp"
#include "compat/registration.hpp"
#include "core/infer/module/host.hpp"
#include "tensor_filter_cpp.hh"
#include "weir/custom_filter.h"

using namespace weir::compat;

// What the engine sets in an object, for each element that opens and closes it.
struct weir_filter_object {
  static unsigned count_users(const tensor_filter_cpp& filter) { return filter.users_; }
  static void add_users(tensor_filter_cpp* filter, unsigned count) { filter->users_ += count; }
  static void set_properties(tensor_filter_cpp* filter, const GstTensorFilterProperties* value) {
    filter->prop = value;
  }
};

namespace {

// An object serves all elements that name it, one call at a time.
struct Object {
  std::mutex turn;                                     // guards the rest
  tensor_filter_cpp* filter;                           // null when it was destroyed
  std::vector<const GstTensorFilterProperties*> open;  // of its elements, the last one opened last
};
struct Objects {
  std::mutex mutex;  // guards the rest
  std::map<std::string, std::shared_ptr<Object>, std::less<>> all;
  std::map<const tensor_filter_cpp*, std::weak_ptr<Object>> living;  // also of those not in `all`
  std::deque<std::string> names;  // engine names, which outlive the objects
};
Objects& objects() {
  static auto& all = *new Objects;  // never freed: elements may outlive static objects
  return all;
}

weir::Failure not_registered(const std::string& name) {
  return weir::Failure({.code = weir::Code::CALLBACK_UNKNOWN,
                        .what = "the filter object is no longer registered",
                        .offered = "framework=cpp model=" + name,
                        .needed = "an object that stays registered while a pipeline uses it"});
}

class OpenObject final : public OpenFilter {
 private:
  template <class Body>
  auto ask(const char* function, Body&& body) {
    const std::lock_guard lock(object_->turn);
    if (!object_->filter) throw not_registered(name());
    return call(function, [&] { return body(*object_->filter); });
  }

 public:
  OpenObject(std::shared_ptr<Object> object, std::unique_ptr<Properties> properties)
      : OpenFilter(std::move(properties)), object_(std::move(object)) {
    this->properties().choose_hardware({}, ACCL_AUTO, ACCL_DEFAULT, false);
    const std::lock_guard lock(object_->turn);
    object_->open.push_back(prop());
    if (!object_->filter) return;
    weir_filter_object::add_users(object_->filter, 1);
    weir_filter_object::set_properties(object_->filter, prop());
  }
  ~OpenObject() override {
    const std::lock_guard lock(object_->turn);
    std::erase(object_->open, prop());
    if (!object_->filter) return;
    weir_filter_object::add_users(object_->filter, -1U);
    weir_filter_object::set_properties(object_->filter,
                                       object_->open.empty() ? nullptr : object_->open.back());
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
  if (found == objects().all.end()) throw not_registered(name);
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

int add(tensor_filter_cpp* filter, unsigned users) {
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
    weir_filter_object::add_users(filter, users);
    objects().living[filter] = object;
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
    : name_(g_strdup(modelName ? modelName : "")), users_(0) {}

tensor_filter_cpp::~tensor_filter_cpp() {
  std::shared_ptr<Object> ours;
  bool is_registered = false;
  {
    const std::lock_guard lock(objects().mutex);
    if (const auto found = objects().living.extract(this)) ours = found.mapped().lock();
    const auto named = objects().all.find(name_);
    is_registered = named != objects().all.end() && named->second == ours;
  }
  if (is_registered) __unregister(name_);
  if (ours) {
    const std::lock_guard lock(ours->turn);
    ours->filter = nullptr;
  }
  valid_ = 0;
  g_free(name_);
}

int tensor_filter_cpp::__register(tensor_filter_cpp* filter, unsigned int ref_count) {
  if (!given(kRegister, {filter})) return -EINVAL;
  return guarded_errno(kRegister, [&] { return add(filter, ref_count); });
}

int tensor_filter_cpp::__unregister(const char* modelName) {
  if (!given("tensor_filter_cpp::__unregister", {modelName})) return -EINVAL;
  return guarded_errno("tensor_filter_cpp::__unregister", [&] {
    std::lock_guard lock(objects().mutex);
    const auto found = objects().all.find(modelName);
    if (found == objects().all.end()) return -EINVAL;
    if (const unsigned users = weir_filter_object::count_users(*found->second->filter); users > 0)
      warn("tensor_filter_cpp::__unregister",
           std::to_string(users) + " elements still use " + modelName);
    objects().all.erase(found);
    return to_errno("tensor_filter_cpp::__unregister", weir_filter_class_unregister(modelName));
  });
}
