// Sets properties from text by the rules of docs/compatibility/filter.md 4.1 for each type.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/property_file.hpp"

#include <cstdlib>

#include "core/text/property_file.hpp"
#include "core/text/text.hpp"
#include "core/text/text_file.hpp"
#include "gstcpp/element/error.hpp"
#include "gstcpp/element/property_text.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {
namespace {

Status set_by_text(GObject* object, GParamSpec* property, const std::string& text) {
  const char* name = property->name;
  switch (G_TYPE_FUNDAMENTAL(property->value_type)) {
    case G_TYPE_BOOLEAN:
      g_object_set(object, name, gboolean{equal_ignoring_case(text, "true")}, nullptr);
      return ok();
    case G_TYPE_INT:
    case G_TYPE_UINT:
      g_object_set(object, name, std::atoi(text.c_str()), nullptr);
      return ok();
    case G_TYPE_INT64:
    case G_TYPE_UINT64:
      g_object_set(object, name, gint64{g_ascii_strtoll(text.c_str(), nullptr, 10)}, nullptr);
      return ok();
    case G_TYPE_FLOAT:
    case G_TYPE_DOUBLE:
      g_object_set(object, name, g_ascii_strtod(text.c_str(), nullptr), nullptr);
      return ok();
    case G_TYPE_STRING:
      g_object_set(object, name, text.c_str(), nullptr);
      return ok();
    default:
      break;
  }
  Value value(property->value_type);
  if (auto status = read_value(GST_ELEMENT(object), property, text, value.get()); !status)
    return status;
  g_object_set_property(object, name, value.get());
  return ok();
}

// Finds the property that a file may set, or returns why it may not.
Result<GParamSpec*> writable_property(GObject* object, const std::string& key) {
  GObjectClass* type = G_OBJECT_GET_CLASS(object);
  GParamSpec* property = g_object_class_find_property(type, key.c_str());
  if (property && (property->flags & G_PARAM_WRITABLE) != 0) return property;
  if (property)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "config-file sets a property that cannot be written; it is ignored",
                 .offered = key};
  guint count = 0;
  GParamSpec** all = g_object_class_list_properties(type, &count);
  std::vector<std::string> names;
  for (guint i = 0; i < count; ++i)
    if (all[i]->flags & G_PARAM_WRITABLE) names.emplace_back(all[i]->name);
  g_free(all);
  const std::string close = nearest(key, names);
  return Error{
      .code = Code::OPTION_VALUE,
      .what = "config-file sets an unknown property; it is ignored",
      .offered = key,
      .needed = close.empty() ? "a property of this element" : "did you mean " + close + "?"};
}

Result<std::string> read_text(const std::string& path) {
  gchar* raw = nullptr;
  gsize size = 0;
  if (!g_file_get_contents(path.c_str(), &raw, &size, nullptr))
    return Error{.code = Code::FILE_NOT_FOUND,
                 .what = "the property file cannot be read",
                 .offered = "config-file=" + path,
                 .needed = "a text file with lines of property=value",
                 .difference = why_unreadable(path),
                 .fix = "config-file=/path/to/properties.conf"};
  const UniqueText text{raw};
  return std::string(text.get(), size);
}

}  // namespace

Status set_properties_from_file(GObject* object, const std::string& path,
                                std::vector<Error>* warnings) {
  const auto text = read_text(path);
  if (!text) return text.error();
  for (const auto& [key, value] : parse_property_file(*text)) {
    if (key == "config-file") continue;
    const auto property = writable_property(object, std::string(key));
    const Status set =
        property ? set_by_text(object, *property, std::string(value)) : Status(property.error());
    if (!set && warnings) warnings->push_back(set.error());
  }
  return ok();
}

Status check_property_file(const std::string& path) {
  if (path.empty()) return ok();
  const auto text = read_text(path);
  return text ? ok() : Status(text.error());
}

void PropertyFile::read(GObject* object, const std::string& path) {
  std::vector<Error> warnings;
  Status status = path.empty() ? ok() : set_properties_from_file(object, path, &warnings);
  std::unique_lock lock(mutex_);
  status_ = std::move(status);
  warnings_ = std::move(warnings);
  lock.unlock();
  auto* element = GST_ELEMENT(object);
  if (GST_STATE(element) < GST_STATE_PAUSED) return;
  if (const Status result = report(element); !result) post_warning(element, result.error());
}

Status PropertyFile::report(GstElement* element) const {
  std::unique_lock lock(mutex_);
  if (!status_) return status_.error();
  const auto warnings = warnings_;
  lock.unlock();
  for (const auto& warning : warnings) post_warning(element, warning);
  return ok();
}

}  // namespace weir::gst
