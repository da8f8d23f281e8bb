// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/caps_text.hpp"

#include "core/text/caps_syntax.hpp"
#include "core/text/shell_quote.hpp"

namespace weir::gst {
namespace {

// g_type_from_name() knows only types that exist already, so a text makes none.
bool is_plain_type(const std::string& name) {
  const GType type = g_type_from_name(name.c_str());
  return type != G_TYPE_INVALID &&
         (G_TYPE_IS_ENUM(type) || G_TYPE_IS_FLAGS(type) || g_type_is_a(type, GST_TYPE_FLAG_SET));
}

Error not_parsed(const char* what, const std::string& text, const char* fix) {
  return Error{.code = Code::OPTION_SYNTAX,
               .what = what,
               .offered = quoted_text(text),
               .needed = "values of the types that the text names",
               .fix = fix};
}

}  // namespace

std::string to_string(const GstCaps* caps) {
  const UniqueText text{gst_caps_to_string(caps)};
  return text.get();
}

Result<Ref<GstCaps>> caps_from_text(const std::string& text) {
  if (auto status = check_caps_text(text, is_plain_type); !status) return status.error();
  auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(text.c_str()));
  if (caps) return caps;
  return not_parsed("the text of caps cannot be used", text,
                    "write caps as gst_caps_to_string() does");
}

Result<UniqueStructure> structure_from_text(const std::string& text) {
  if (auto status = check_structure_text(text, is_plain_type); !status) return status.error();
  gchar* end = nullptr;
  UniqueStructure structure(gst_structure_from_string(text.c_str(), &end));
  if (structure) return Result<UniqueStructure>(std::move(structure));
  return not_parsed("the text of a structure cannot be used", text,
                    "write a structure as gst_structure_to_string() does");
}

}  // namespace weir::gst
