// Maps Weir's codes to GStreamer's error domains and fills the details structure.
#include "gstcpp/error.hpp"

#include <string>

namespace weir::gst {
namespace {

struct Domain {
  GQuark quark;
  int code;
};

Domain domain_of(Code code) {
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

GstStructure* details_of(const Error& error) {
  const std::string id = "WEIR-" + std::to_string(static_cast<int>(error.code));
  return gst_structure_new(
      "weir-error", "code", G_TYPE_UINT, static_cast<guint>(error.code), "id", G_TYPE_STRING,
      id.c_str(), "what", G_TYPE_STRING, error.what.c_str(), "offered", G_TYPE_STRING,
      error.offered.c_str(), "needed", G_TYPE_STRING, error.needed.c_str(), "difference",
      G_TYPE_STRING, error.difference.c_str(), "fix", G_TYPE_STRING, error.fix.c_str(), nullptr);
}

void post(GstElement* element, GstMessageType type, const Error& error) {
  const Domain domain = domain_of(error.code);
  gst_element_message_full_with_details(element, type, domain.quark, domain.code,
                                        g_strdup(error.message().c_str()), nullptr, __FILE__,
                                        __func__, __LINE__, details_of(error));
}

}  // namespace

void post_error(GstElement* element, const Error& error) {
  post(element, GST_MESSAGE_ERROR, error);
}

void post_warning(GstElement* element, const Error& error) {
  post(element, GST_MESSAGE_WARNING, error);
}

}  // namespace weir::gst
