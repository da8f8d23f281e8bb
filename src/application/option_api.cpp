// ml_option_*, and ml_information_*, which no call of this library creates.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/text/error_text.hpp"
#include "ml_error.hpp"
#include "option.hpp"

namespace weir::application {

Option::~Option() {
  for (const auto& [key, value] : values_) value.release();
}

void Option::set(const std::string& key, Value value) {
  {
    std::lock_guard lock(mutex_);
    std::swap(values_[key], value);
  }
  value.release();
}

void* Option::get(const std::string& key) const {
  std::lock_guard lock(mutex_);
  const auto found = values_.find(key);
  return found == values_.end() ? nullptr : found->second.pointer;
}

std::vector<std::string> Option::keys() const {
  std::lock_guard lock(mutex_);
  std::vector<std::string> out;
  for (const auto& [key, value] : values_) out.push_back(key);
  return out;
}

}  // namespace weir::application

namespace {

using namespace weir;
using namespace weir::application;

class Information : public Object {
 public:
  static constexpr const char* kKind = "information";
};

class InformationList : public Object {
 public:
  static constexpr const char* kKind = "information list";
};

// No handle has such an object.
template <class T>
int no_handle_of(void* handle, const char* what) {
  return guarded([&] { return fail(Handles::all().find<T>(handle, what).error()); });
}

}  // namespace

int ml_option_create(ml_option_h* option) {
  return guarded([&] {
    if (!option) return fail(null_pointer("option"));
    *option = Handles::all().add(std::make_shared<Option>());
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_option_destroy(ml_option_h option) {
  return guarded([&] {
    const auto taken = Handles::all().take<Option>(option, "option");
    return taken ? static_cast<int>(ML_ERROR_NONE) : fail(taken.error());
  });
}

int ml_option_set(ml_option_h option, const char* key, void* value, ml_data_destroy_cb destroy) {
  return guarded([&] {
    if (!key || !value) return fail(null_pointer("key or value"));
    if (!*key) return fail(Error{.code = Code::OPTION_VALUE, .what = "key is empty"});
    const auto found = Handles::all().find<Option>(option, "option");
    if (!found) return fail(found.error());
    (*found)->set(key, {value, destroy});
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_option_get(ml_option_h option, const char* key, void** value) {
  return guarded([&] {
    if (!key || !value) return fail(null_pointer("key or value"));
    const auto found = Handles::all().find<Option>(option, "option");
    if (!found) return fail(found.error());
    void* const pointer = (*found)->get(key);
    if (!pointer) return fail(not_one_of("the option has no such key", key, (*found)->keys()));
    *value = pointer;
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_information_get(ml_information_h information, const char* key, void** value) {
  if (!key || !value) return fail(null_pointer("key or value"));
  return no_handle_of<Information>(information, "information");
}

int ml_information_destroy(ml_information_h information) {
  return no_handle_of<Information>(information, "information");
}

int ml_information_list_length(ml_information_list_h list, unsigned int* length) {
  return length ? no_handle_of<InformationList>(list, "list") : fail(null_pointer("length"));
}

int ml_information_list_get(ml_information_list_h list, unsigned int,
                            ml_information_h* information) {
  return information ? no_handle_of<InformationList>(list, "list")
                     : fail(null_pointer("information"));
}

int ml_information_list_destroy(ml_information_list_h list) {
  return no_handle_of<InformationList>(list, "list");
}
