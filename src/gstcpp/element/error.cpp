// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/error.hpp"

#include <string>

#include "gstcpp/element/log.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {
namespace {

struct Domain {
  GQuark quark;
  int code;
};

Domain to_domain(Code code) {
  switch (static_cast<int>(code) / 1000) {
    case 1:
      return {GST_LIBRARY_ERROR, GST_LIBRARY_ERROR_SETTINGS};
    case 2:
      if (code == Code::NOT_NEGOTIATED) return {GST_STREAM_ERROR, GST_STREAM_ERROR_WRONG_TYPE};
      return code == Code::SPEC_MISMATCH || code == Code::FORMAT_UNSUPPORTED
                 ? Domain{GST_STREAM_ERROR, GST_STREAM_ERROR_FORMAT}
                 : Domain{GST_STREAM_ERROR, GST_STREAM_ERROR_FAILED};
    case 3:
      if (code == Code::MODEL_NOT_FOUND) return {GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_NOT_FOUND};
      return {GST_LIBRARY_ERROR, GST_LIBRARY_ERROR_INIT};
    case 4:
      return {GST_RESOURCE_ERROR, code == Code::FILE_NOT_FOUND ? GST_RESOURCE_ERROR_NOT_FOUND
                                                               : GST_RESOURCE_ERROR_READ};
    case 8:
      return {GST_CORE_ERROR, GST_CORE_ERROR_STATE_CHANGE};
    default:
      return {GST_CORE_ERROR, GST_CORE_ERROR_FAILED};
  }
}

GstStructure* make_details(const Error& error) {
  const std::string id = "WEIR-" + std::to_string(static_cast<int>(error.code));
  return gst_structure_new("weir-error", "code", G_TYPE_UINT, static_cast<guint>(error.code), "id",
                           G_TYPE_STRING, id.c_str(), "what", G_TYPE_STRING,
                           printable_text(error.what).c_str(), "offered", G_TYPE_STRING,
                           printable_text(error.offered).c_str(), "needed", G_TYPE_STRING,
                           printable_text(error.needed).c_str(), "difference", G_TYPE_STRING,
                           printable_text(error.difference).c_str(), "fix", G_TYPE_STRING,
                           printable_text(error.fix).c_str(), nullptr);
}

thread_local GstElement* trying_caps = nullptr;
thread_local uint64_t errors_posted = 0;

GQuark refusal_quark() {
  static const GQuark quark = g_quark_from_static_string("weir-refusal");
  return quark;
}

void remember_refusal(GstElement* element, char* text) {
  GST_OBJECT_LOCK(element);
  const auto before = g_object_steal_qdata(G_OBJECT(element), refusal_quark());
  if (text) g_object_set_qdata_full(G_OBJECT(element), refusal_quark(), text, g_free);
  GST_OBJECT_UNLOCK(element);
  g_free(before);
}

// Remembers the last rejection of caps; true if it had the same text.
bool was_refused_so(GstElement* element, const std::string& text) {
  GST_OBJECT_LOCK(element);
  const auto* before =
      static_cast<const char*>(g_object_get_qdata(G_OBJECT(element), refusal_quark()));
  const bool same = before && text == before;
  GST_OBJECT_UNLOCK(element);
  if (!same) remember_refusal(element, g_strdup(text.c_str()));
  return same;
}

void post(GstElement* element, GstMessageType type, const Error& error) {
  const Domain domain = to_domain(error.code);
  const std::string text = error.message();
  if (type == GST_MESSAGE_ERROR) ++errors_posted;
  if (type == GST_MESSAGE_ERROR && element == trying_caps && was_refused_so(element, text)) {
    GST_CAT_DEBUG_OBJECT(get_category(element), element, "caps rejected again: %s", text.c_str());
    return;
  }
  GST_CAT_LEVEL_LOG(get_category(element),
                    type == GST_MESSAGE_ERROR ? GST_LEVEL_ERROR : GST_LEVEL_WARNING, element, "%s",
                    text.c_str());
  gst_element_message_full_with_details(element, type, domain.quark, domain.code,
                                        g_strdup(text.c_str()), nullptr, __FILE__, __func__,
                                        __LINE__, make_details(error));
}

}  // namespace

CapsTrial::CapsTrial(GstElement* element, bool of_caps)
    : element_(of_caps ? element : nullptr), outer_(trying_caps) {
  if (of_caps) trying_caps = element;
}

CapsTrial::CapsTrial(GstElement* element, GstEvent* event)
    : CapsTrial(element, GST_EVENT_TYPE(event) == GST_EVENT_CAPS) {
  if (!element_) return;
  GstCaps* caps = nullptr;
  gst_event_parse_caps(event, &caps);
  GST_CAT_INFO_OBJECT(get_category(element), element, "input caps %" GST_PTR_FORMAT,
                      static_cast<void*>(caps));
}

CapsTrial::~CapsTrial() {
  trying_caps = outer_;
}

gboolean CapsTrial::ended(gboolean taken) {
  if (element_)
    GST_CAT_DEBUG_OBJECT(get_category(element_), element_, "caps are %s",
                         taken ? "accepted" : "rejected");
  if (element_ && taken) forget_refusal(element_);
  return taken;
}

void forget_refusal(GstElement* element) {
  remember_refusal(element, nullptr);
}

void post_error(GstElement* element, const Error& error) {
  post(element, GST_MESSAGE_ERROR, error);
}

uint64_t errors_posted_by_this_thread() noexcept {
  return errors_posted;
}

Error property_is_fixed(const char* name, const GValue* value) {
  const UniqueText text{gst_value_serialize(value)};
  return Error{
      .code = Code::OPTION_VALUE,
      .what = std::string("the property ") + name + " cannot change while the element runs",
      .offered = std::string(name) + "=" + (text ? text.get() : "NULL"),
      .needed = "the element in the state NULL or READY",
      .fix = "gst_element_set_state (element, GST_STATE_READY)"};
}

void post_warning(GstElement* element, const Error& error) {
  post(element, GST_MESSAGE_WARNING, error);
}

Error buffer_before_caps(std::string fix, std::string pad) {
  return Error{.code = Code::NOT_NEGOTIATED,
               .what = "a buffer arrived before caps",
               .offered = std::move(pad),
               .needed = "caps",
               .difference = {},
               .fix = std::move(fix)};
}

}  // namespace weir::gst
