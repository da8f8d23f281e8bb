// ml_pipeline_element_*: get and set properties of the type in the function's name.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <charconv>
#include <cstring>
#include <optional>
#include <type_traits>

#include "pipeline_part.hpp"

namespace {

using namespace weir;
using namespace weir::application;

class Element : public PipelinePart {
 public:
  static constexpr const char* kKind = "element";
  using PipelinePart::PipelinePart;
  const char* kind() const noexcept override { return kKind; }
};

const char* name_of_type(int type) {
  constexpr const char* kNames[]{"",       "a type that this API does not support",
                                 "bool",   "int32",
                                 "uint32", "int64",
                                 "uint64", "double",
                                 "string", "enum"};
  return kNames[type];
}

// An enum can be set and read as a number.
bool is_enum_as_number(int found, int type) {
  return found == WEIR_PROPERTY_ENUM &&
         (type == WEIR_PROPERTY_INT32 || type == WEIR_PROPERTY_UINT32);
}

// Runs `body` with an element if its property has this type.
template <class Body>
int with_property(void* handle, const char* property, int type, Body&& body) {
  return with_part<Element>(
      handle, "elem_h", [&](weir_pipeline* pipeline, const char* name, weir_error** error) {
        const int found = weir_pipeline_property_type(pipeline, name, property, error);
        if (found < 0) return found;
        if (found == type || is_enum_as_number(found, type))
          return body(pipeline, name, found, error);
        const std::string call = std::string("ml_pipeline_element_set_property_") +
                                 name_of_type(found) + "() or ml_pipeline_element_get_property_" +
                                 name_of_type(found) + "()";
        *error = weir_error_new(
            WEIR_OPTION_VALUE,
            ("the property " + std::string(property) + " of " + name + " has a different type")
                .c_str(),
            name_of_type(type), name_of_type(found), "",
            found == WEIR_PROPERTY_OTHER ? "" : call.c_str());
        return -static_cast<int>(WEIR_OPTION_VALUE);
      });
}

int set(void* handle, const char* property, int type, const std::string& value) {
  return with_property(handle, property, type,
                       [&](weir_pipeline* pipeline, const char* name, int, weir_error** error) {
                         return weir_pipeline_set(pipeline, name, property, value.c_str(), error);
                       });
}

// A negative value is a large unsigned number.
std::string format_enum(int32_t value, int type) {
  return type == WEIR_PROPERTY_UINT32 ? std::to_string(static_cast<uint32_t>(value))
                                      : std::to_string(value);
}

std::string format_number(double value) {
  char text[64];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

// `take` parses the property's text and returns whether it is valid.
template <class Take>
int get(void* handle, const char* property, int type, Take&& take) {
  return with_property(
      handle, property, type,
      [&](weir_pipeline* pipeline, const char* name, int found, weir_error** error) {
        int32_t number = 0;
        if (is_enum_as_number(found, type) &&
            weir_pipeline_get_enum(pipeline, name, property, &number, nullptr) >= 0 &&
            take(format_enum(number, type).c_str()))
          return 0;
        char* text = nullptr;
        const int result = weir_pipeline_get(pipeline, name, property, &text, error);
        if (result < 0) return result;
        const std::unique_ptr<char, decltype(&weir_pipeline_text_free)> owner(
            text, weir_pipeline_text_free);
        if (take(text)) return 0;
        *error = weir_error_new(WEIR_INTERNAL,
                                ("the value of the property " + std::string(property) + " of " +
                                 name + " cannot be read")
                                    .c_str(),
                                text, name_of_type(type), "", "");
        return -static_cast<int>(WEIR_INTERNAL);
      });
}

template <class T>
int get_number(void* handle, const char* property, int type, T* value) {
  if (!value) return fail(null_pointer("value"));
  return get(handle, property, type, [&](const char* text) {
    const char* end = text + std::strlen(text);
    const auto [at, fault] = std::from_chars(text, end, *value);
    return fault == std::errc() && at == end;
  });
}

}  // namespace

int ml_pipeline_element_get_handle(ml_pipeline_h pipe, const char* element_name,
                                   ml_pipeline_element_h* elem_h) {
  return get_part<Element>(pipe, element_name, "", elem_h);
}

int ml_pipeline_element_release_handle(ml_pipeline_element_h elem_h) {
  return release_part<Element>(elem_h, "elem_h");
}

int ml_pipeline_element_set_property_bool(ml_pipeline_element_h elem_h, const char* property_name,
                                          const int32_t value) {
  return guarded([&] {
    if (value != 0 && value != 1)
      return fail(Error{.code = Code::OPTION_VALUE,
                        .what = "value is not a boolean",
                        .offered = std::to_string(value),
                        .needed = "0 or 1"});
    return set(elem_h, property_name, WEIR_PROPERTY_BOOL, value != 0 ? "true" : "false");
  });
}

int ml_pipeline_element_set_property_string(ml_pipeline_element_h elem_h, const char* property_name,
                                            const char* value) {
  return guarded([&] {
    if (!value) return fail(null_pointer("value"));
    return set(elem_h, property_name, WEIR_PROPERTY_STRING, value);
  });
}

int ml_pipeline_element_set_property_int32(ml_pipeline_element_h elem_h, const char* property_name,
                                           const int32_t value) {
  return guarded(
      [&] { return set(elem_h, property_name, WEIR_PROPERTY_INT32, std::to_string(value)); });
}

int ml_pipeline_element_set_property_int64(ml_pipeline_element_h elem_h, const char* property_name,
                                           const int64_t value) {
  return guarded(
      [&] { return set(elem_h, property_name, WEIR_PROPERTY_INT64, std::to_string(value)); });
}

int ml_pipeline_element_set_property_uint32(ml_pipeline_element_h elem_h, const char* property_name,
                                            const uint32_t value) {
  return guarded([&] {
    return with_property(
        elem_h, property_name, WEIR_PROPERTY_UINT32,
        [&](weir_pipeline* pipeline, const char* name, int found, weir_error** error) {
          const std::string text = found == WEIR_PROPERTY_ENUM
                                       ? std::to_string(static_cast<int32_t>(value))
                                       : std::to_string(value);
          return weir_pipeline_set(pipeline, name, property_name, text.c_str(), error);
        });
  });
}

int ml_pipeline_element_set_property_uint64(ml_pipeline_element_h elem_h, const char* property_name,
                                            const uint64_t value) {
  return guarded(
      [&] { return set(elem_h, property_name, WEIR_PROPERTY_UINT64, std::to_string(value)); });
}

int ml_pipeline_element_set_property_double(ml_pipeline_element_h elem_h, const char* property_name,
                                            const double value) {
  return guarded(
      [&] { return set(elem_h, property_name, WEIR_PROPERTY_DOUBLE, format_number(value)); });
}

int ml_pipeline_element_set_property_enum(ml_pipeline_element_h elem_h, const char* property_name,
                                          const uint32_t value) {
  return guarded([&] {
    // Negative enum values arrive as unsigned numbers.
    return set(elem_h, property_name, WEIR_PROPERTY_ENUM,
               std::to_string(static_cast<int32_t>(value)));
  });
}

int ml_pipeline_element_get_property_bool(ml_pipeline_element_h elem_h, const char* property_name,
                                          int32_t* value) {
  return guarded([&] {
    if (!value) return fail(null_pointer("value"));
    return get(elem_h, property_name, WEIR_PROPERTY_BOOL, [&](const char* text) {
      *value = std::strcmp(text, "true") == 0;
      return true;
    });
  });
}

int ml_pipeline_element_get_property_string(ml_pipeline_element_h elem_h, const char* property_name,
                                            char** value) {
  return guarded([&] {
    if (!value) return fail(null_pointer("value"));
    return get(elem_h, property_name, WEIR_PROPERTY_STRING, [&](const char* text) {
      char* const copy = strdup(text);
      if (copy) *value = copy;
      return copy != nullptr;
    });
  });
}

int ml_pipeline_element_get_property_int32(ml_pipeline_element_h elem_h, const char* property_name,
                                           int32_t* value) {
  return guarded([&] { return get_number(elem_h, property_name, WEIR_PROPERTY_INT32, value); });
}

int ml_pipeline_element_get_property_int64(ml_pipeline_element_h elem_h, const char* property_name,
                                           int64_t* value) {
  return guarded([&] { return get_number(elem_h, property_name, WEIR_PROPERTY_INT64, value); });
}

int ml_pipeline_element_get_property_uint32(ml_pipeline_element_h elem_h, const char* property_name,
                                            uint32_t* value) {
  return guarded([&] { return get_number(elem_h, property_name, WEIR_PROPERTY_UINT32, value); });
}

int ml_pipeline_element_get_property_uint64(ml_pipeline_element_h elem_h, const char* property_name,
                                            uint64_t* value) {
  return guarded([&] { return get_number(elem_h, property_name, WEIR_PROPERTY_UINT64, value); });
}

int ml_pipeline_element_get_property_double(ml_pipeline_element_h elem_h, const char* property_name,
                                            double* value) {
  return guarded([&] { return get_number(elem_h, property_name, WEIR_PROPERTY_DOUBLE, value); });
}

int ml_pipeline_element_get_property_enum(ml_pipeline_element_h elem_h, const char* property_name,
                                          uint32_t* value) {
  return guarded([&] {
    if (!value) return fail(null_pointer("value"));
    return with_property(elem_h, property_name, WEIR_PROPERTY_ENUM,
                         [&](weir_pipeline* pipeline, const char* name, int, weir_error** error) {
                           int32_t number = 0;
                           const int result = weir_pipeline_get_enum(pipeline, name, property_name,
                                                                     &number, error);
                           if (result >= 0) *value = static_cast<uint32_t>(number);
                           return result;
                         });
  });
}
